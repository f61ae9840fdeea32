# Compiles the kernels, which are all sources of simd but the one that asks the processor, once per instruction set,
# each time into a namespace of its own.
# Kernels are optimized in every build type: an unoptimized wide kernel is of no use to anybody.
file(GLOB_RECURSE SCREE_KERNEL_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
list(REMOVE_ITEM SCREE_KERNEL_SOURCES ${CMAKE_CURRENT_LIST_DIR}/dispatch/dispatch.cpp)
set(SCREE_KERNEL_OBJECTS "")

# Instrumented for a sanitizer, the largest kernels take g++ minutes at -O3 or with full debug information.
if(SCREE_SANITIZE)
  set(SCREE_KERNEL_OPTIMIZATION -O1 -g1)
else()
  set(SCREE_KERNEL_OPTIMIZATION -O3)
endif()

function(scree_add_instruction_set name lanes)
  set(target scree_kernels_${name})
  add_library(${target} OBJECT ${SCREE_KERNEL_SOURCES})
  target_link_libraries(${target} PRIVATE scree_flags)
  target_compile_definitions(${target} PRIVATE SCREE_SIMD_NAMESPACE=${name} SCREE_SIMD_LANES=${lanes})
  target_compile_options(${target} PRIVATE ${ARGN} ${SCREE_KERNEL_OPTIMIZATION} -fno-exceptions -fno-rtti
    -fno-math-errno)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(SCREE_PRECOMPILED_HEADERS)
    # Xsimd and the compilers' headers of intrinsics take a second of each kernel's time.
    target_precompile_headers(${target} PRIVATE <simd/wide/wide_angles.h> <simd/wide/wide_math.h>)
  endif()
  set(SCREE_KERNEL_OBJECTS ${SCREE_KERNEL_OBJECTS} $<TARGET_OBJECTS:${target}> PARENT_SCOPE)
endfunction()

foreach(set IN LISTS SCREE_INSTRUCTION_SETS)
  if(NOT set MATCHES "^(scalar|sse2|avx2|avx512)$")
    message(FATAL_ERROR "SCREE_INSTRUCTION_SETS names ${set}; there are scalar, sse2, avx2 and avx512")
  endif()
endforeach()

scree_add_instruction_set(scalar 1)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  find_package(xsimd 8.1 REQUIRED)
  get_target_property(xsimd_include xsimd INTERFACE_INCLUDE_DIRECTORIES)
  if("sse2" IN_LIST SCREE_INSTRUCTION_SETS)
    scree_add_instruction_set(sse2 4 -msse2 -mno-sse3)
  endif()
  if("avx2" IN_LIST SCREE_INSTRUCTION_SETS)
    scree_add_instruction_set(avx2 8 -mavx2 -mno-fma)
  endif()
  # Clang takes -mno-fma for -mno-avx512f, which includes it; there -ffp-contract=off alone prevents fusing.
  # GCC 12 takes the deliberately undefined registers of its own AVX-512 intrinsics for mistakes of the caller.
  if("avx512" IN_LIST SCREE_INSTRUCTION_SETS)
    scree_add_instruction_set(avx512 16 -mavx512f -mavx512cd -mavx512dq -mavx512bw -mavx512vl
      $<$<CXX_COMPILER_ID:GNU>:-mno-fma -mprefer-vector-width=512 -Wno-uninitialized -Wno-maybe-uninitialized>)
  endif()
  foreach(set sse2 avx2 avx512)
    if(TARGET scree_kernels_${set})
      target_include_directories(scree_kernels_${set} SYSTEM PRIVATE ${xsimd_include})
      string(TOUPPER ${set} name)
      target_compile_definitions(scree_flags INTERFACE SCREE_HAS_${name}=1)
    endif()
  endforeach()
endif()
