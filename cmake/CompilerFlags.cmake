# stiffront_compile_flags(<target>): the flags on which bitwise reproducibility and clean builds rest.
#
# -ffp-contract=off: a contracted multiply-add differs from an uncontracted one, and the compiler contracts the vector
# body and the scalar tail of a loop differently, so results would depend on where a rank boundary lies. Fused
# operations are written out in the pack code (core/simd.hpp). Fast-math is never used.
# -fno-math-errno and -fno-trapping-math change no value: the first drops the setting of errno, the second lets the
# compiler if-convert operations that could raise a flag; the dev build keeps traps.
function(stiffront_compile_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 sees overlapping copies in "text" + std::string (GCC bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  target_compile_definitions(${target} PUBLIC OMPI_SKIP_MPICXX)
  if(STIFFRONT_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY" OR type STREQUAL "SHARED_LIBRARY")
    set(scope PUBLIC)  # templates instantiated by a user must have the same arithmetic and the same pack width
  else()
    set(scope PRIVATE)
  endif()
  target_compile_options(${target} ${scope} -ffp-contract=off -fno-math-errno)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O3 -fno-trapping-math)
  endif()
  if(STIFFRONT_NATIVE)
    target_compile_options(${target} ${scope} -march=native -mprefer-vector-width=512)
  endif()
  if(STIFFRONT_SANITIZE)
    target_compile_options(${target} ${scope} -fsanitize=${STIFFRONT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} ${scope} -fsanitize=${STIFFRONT_SANITIZE})
  endif()
endfunction()
