// Visibility of the shared library's symbols: everything is hidden but what carries SCREE_API. A class nested
// in such a one inherits its visibility and takes SCREE_HIDDEN to stay inside.
#pragma once

#if defined(SCREE_SHARED) && defined(__GNUC__)
#define SCREE_API __attribute__((visibility("default")))
#define SCREE_HIDDEN __attribute__((visibility("hidden")))
#else
#define SCREE_API
#define SCREE_HIDDEN
#endif
