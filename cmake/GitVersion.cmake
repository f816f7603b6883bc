# Records what was built from what in the generated header core/version.hpp.
find_package(Git QUIET)
set(STIFFRONT_GIT_HASH "")
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --always --dirty --abbrev=12
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE STIFFRONT_GIT_HASH
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  # Every commit and checkout writes a line here: configure again then, so that the hash is that of what is built.
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --path-format=absolute --git-path logs/HEAD
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE git_log OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(git_log AND EXISTS ${git_log})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${git_log})
  endif()
endif()
if(NOT STIFFRONT_GIT_HASH)  # no git, no repository, or one that git does not trust
  set(STIFFRONT_GIT_HASH "unknown")
endif()
set(STIFFRONT_COMPILER "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
set(STIFFRONT_FLAGS "${CMAKE_BUILD_TYPE} -ffp-contract=off")
if(STIFFRONT_NATIVE)
  string(APPEND STIFFRONT_FLAGS " -march=native")
endif()
if(STIFFRONT_SANITIZE)
  string(APPEND STIFFRONT_FLAGS " -fsanitize=${STIFFRONT_SANITIZE}")
endif()
configure_file(${PROJECT_SOURCE_DIR}/include/stiffront/core/version.hpp.in
               ${PROJECT_BINARY_DIR}/generated/stiffront/core/version.hpp @ONLY)
