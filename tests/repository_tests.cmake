# What is claimed about the repository as a whole: its layers, its documents, its install tree, its plot script.
add_test(NAME layering
  COMMAND ${CMAKE_COMMAND} -D ROOT=${PROJECT_SOURCE_DIR} -P ${PROJECT_SOURCE_DIR}/cmake/CheckLayering.cmake)
add_test(NAME layering.check_finds_broken_trees
  COMMAND ${CMAKE_COMMAND} -D CHECK=${PROJECT_SOURCE_DIR}/cmake/CheckLayering.cmake
          -D WORK=${CMAKE_CURRENT_BINARY_DIR}/layering -P ${CMAKE_CURRENT_SOURCE_DIR}/layering/layering_test.cmake)
add_test(NAME documentation.links
  COMMAND ${CMAKE_COMMAND} -D ROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/docs/links_test.cmake)
set_tests_properties(documentation.links layering layering.check_finds_broken_trees PROPERTIES LABELS repository TIMEOUT 60)

find_program(STIFFRONT_DOXYGEN NAMES doxygen)
if(STIFFRONT_DOXYGEN)
  add_test(NAME documentation.doxygen
    COMMAND sh -c "(cat docs/Doxyfile; echo OUTPUT_DIRECTORY=${CMAKE_CURRENT_BINARY_DIR}/doxygen) | ${STIFFRONT_DOXYGEN} -"
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(documentation.doxygen PROPERTIES LABELS repository TIMEOUT 120)
endif()

foreach(step install find_package pkg_config)
  add_test(NAME consumer.${step}
    COMMAND ${CMAKE_COMMAND} -D STEP=${step} -D BUILD=${PROJECT_BINARY_DIR} -D SOURCE=${CMAKE_CURRENT_SOURCE_DIR}/consumer
            -D WORK=${CMAKE_CURRENT_BINARY_DIR}/consumer -D VERSION=${PROJECT_VERSION} -D CXX=${CMAKE_CXX_COMPILER}
            -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/consumer_test.cmake)
  set_tests_properties(consumer.${step} PROPERTIES LABELS repository TIMEOUT 280
    ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1;ASAN_OPTIONS=detect_leaks=0")
endforeach()
set_tests_properties(consumer.install PROPERTIES FIXTURES_SETUP install_tree)
set_tests_properties(consumer.find_package consumer.pkg_config PROPERTIES FIXTURES_REQUIRED install_tree)

find_program(STIFFRONT_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH)  # Debian's, which sees Debian's modules
if(STIFFRONT_PYTHON)
  add_test(NAME plot COMMAND ${STIFFRONT_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/plot/plot_test.py)
  add_test(NAME report COMMAND ${STIFFRONT_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/plot/report_test.py)
  add_test(NAME xdmf COMMAND ${STIFFRONT_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/plot/xdmf_test.py $<TARGET_FILE:stiffront_program>)
  add_test(NAME documentation.examples
    COMMAND ${STIFFRONT_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/docs/examples_test.py $<TARGET_FILE:stiffront_program> ${PROJECT_SOURCE_DIR})
  set_tests_properties(xdmf documentation.examples PROPERTIES ENVIRONMENT "OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1")
  set_tests_properties(plot report xdmf documentation.examples PROPERTIES LABELS repository TIMEOUT 120 SKIP_RETURN_CODE 77)
endif()
