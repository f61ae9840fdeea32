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

// In front of small functions of public headers: they are always inlined, so that no copy of them is compiled
// as a function. A linker that finds several copies keeps one for the library and the program. One that was
// built with fast-math or with fused multiplications would change the library's bits.
#if defined(__GNUC__)
#define SCREE_INLINE [[gnu::always_inline]] inline
#else
#define SCREE_INLINE inline
#endif
