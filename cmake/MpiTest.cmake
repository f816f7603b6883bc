# mpi_test(NAME n SOURCES ... RANKS 1 2 3 4): one test per rank count. More ranks than cores are the rule here, so
# ranks yield while they wait and are bound to nothing. Named transports spare the search for networks (0.2 s a run).
set(STIFFRONT_MPI_ENVIRONMENT
  OMPI_MCA_pml=ob1 OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
  ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1)

function(mpi_test)
  cmake_parse_arguments(arg "" "NAME" "SOURCES;RANKS" ${ARGN})
  add_executable(${arg_NAME} ${arg_SOURCES} ${PROJECT_SOURCE_DIR}/mpi-tests/support/mpi_main.cpp
    ${PROJECT_SOURCE_DIR}/mpi-tests/support/mpi_ledger.cpp)
  target_include_directories(${arg_NAME} PRIVATE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/mpi-tests)
  target_link_libraries(${arg_NAME} PRIVATE stiffront::stiffront GTest::gtest)
  target_compile_definitions(${arg_NAME} PRIVATE STIFFRONT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  stiffront_compile_flags(${arg_NAME})
  foreach(ranks ${arg_RANKS})
    add_test(NAME ${arg_NAME}.on_${ranks}
      COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} $<TARGET_FILE:${arg_NAME}>)
    set_tests_properties(${arg_NAME}.on_${ranks} PROPERTIES
      PROCESSORS ${ranks} TIMEOUT 120 LABELS mpi ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
  endforeach()
endfunction()
