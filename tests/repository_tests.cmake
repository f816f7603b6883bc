# What is claimed about the repository as a whole.
add_test(NAME layering
  COMMAND ${CMAKE_COMMAND} -D ROOT=${PROJECT_SOURCE_DIR} -P ${PROJECT_SOURCE_DIR}/cmake/CheckLayering.cmake)
add_test(NAME layering.check_finds_broken_trees
  COMMAND ${CMAKE_COMMAND} -D CHECK=${PROJECT_SOURCE_DIR}/cmake/CheckLayering.cmake
          -D WORK=${CMAKE_CURRENT_BINARY_DIR}/layering -P ${CMAKE_CURRENT_SOURCE_DIR}/layering/layering_test.cmake)
set_tests_properties(layering layering.check_finds_broken_trees PROPERTIES LABELS repository TIMEOUT 60)

