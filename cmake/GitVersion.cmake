# Records what was built from what in the generated header core/version.hpp.
find_package(Git QUIET)
set(STIFFRONT_GIT_HASH "unknown")
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --always --dirty --abbrev=12
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE STIFFRONT_GIT_HASH
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
set(STIFFRONT_COMPILER "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
if(STIFFRONT_NATIVE)
  set(STIFFRONT_FLAGS "${CMAKE_BUILD_TYPE} -march=native -ffp-contract=off ${STIFFRONT_SANITIZE}")
else()
  set(STIFFRONT_FLAGS "${CMAKE_BUILD_TYPE} -ffp-contract=off ${STIFFRONT_SANITIZE}")
endif()
configure_file(${PROJECT_SOURCE_DIR}/include/stiffront/core/version.hpp.in
               ${PROJECT_BINARY_DIR}/generated/stiffront/core/version.hpp @ONLY)
