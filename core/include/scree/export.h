// Visibility of the shared library's symbols: everything is hidden but what carries SCREE_API.
#pragma once

#if defined(SCREE_SHARED) && defined(__GNUC__)
#define SCREE_API __attribute__((visibility("default")))
#else
#define SCREE_API
#endif
