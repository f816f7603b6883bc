# The program itself: output, exit status, one voice under mpirun.
include(MpiTest)
add_test(NAME program
  COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/program/program_test.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE}
          ${PROJECT_SOURCE_DIR})
set_tests_properties(program PROPERTIES LABELS program PROCESSORS 2 TIMEOUT 120 ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
