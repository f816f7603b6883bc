# How a job ends when ranks fail.
add_executable(job_failures faults/job_failures.cpp)
target_link_libraries(job_failures PRIVATE stiffront::stiffront)
stiffront_compile_flags(job_failures)
add_test(NAME faults.job_failures
  COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/faults/job_failures.sh $<TARGET_FILE:job_failures> ${MPIEXEC_EXECUTABLE})
set_tests_properties(faults.job_failures PROPERTIES LABELS fault PROCESSORS 2 TIMEOUT 120
  ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
