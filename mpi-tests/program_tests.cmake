# How a job ends when ranks fail.
add_executable(job_failures faults/job_failures.cpp)
target_link_libraries(job_failures PRIVATE stiffront::stiffront)
stiffront_compile_flags(job_failures)
add_test(NAME faults.job_failures
  COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/faults/job_failures.sh $<TARGET_FILE:job_failures> ${MPIEXEC_EXECUTABLE})
set_tests_properties(faults.job_failures PROPERTIES LABELS fault PROCESSORS 2 TIMEOUT 120
  ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")

# The program itself: a case gives the same bits on every number and layout of ranks.
function(same_bits_test name case layouts)
  add_test(NAME same_bits.${name}
    COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/same_bits.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE}
            ${PROJECT_SOURCE_DIR}/drivers/cases/${case}.toml ${layouts} ${ARGN})
  set_tests_properties(same_bits.${name} PROPERTIES
    PROCESSORS 4 TIMEOUT 240 LABELS "mpi;program" ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
endfunction()

set(lines "1x1 2x1 3x1 4x1")
set(boxes "1x1 2x1 1x3 2x2")
same_bits_test(strang-1d bz-1d "${lines}" method.name=strang method.step=1e-3 time.end=0.02)
same_bits_test(adaptive-strang-1d bz-1d "${lines}" method.name=adaptive-strang method.tolerance=1e-4 time.end=0.01)
same_bits_test(dcs-1d bz-1d "${lines}" --rejections method.name=dcs method.tolerance=1e-6 time.end=8e-3)
same_bits_test(dcs-strang-1d lambda-omega-1d "${lines}" --rejections method.name=dcs method.splitting=strang method.tolerance=1e-5 time.end=0.2)
same_bits_test(dcs-2d brusselator-2d "${boxes}" --rejections "grid.points=[33, 31]" method.name=dcs method.tolerance=1e-4 time.end=0.2)
same_bits_test(adaptive-strang-2d bz-2d-spiral "${boxes}" "grid.points=[67, 61]" method.name=adaptive-strang method.tolerance=1e-3 time.end=0.01)
same_bits_test(strang-order-4 brusselator-2d "${boxes}" "grid.points=[67, 61]" space.order=4 method.name=strang method.step=0.05 time.end=0.2)

# Restarts continue bitwise, also on another number of ranks.
function(restart_test name case every)
  add_test(NAME restart.${name}
    COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/restart.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE}
            ${PROJECT_SOURCE_DIR}/drivers/cases/${case}.toml ${every} ${ARGN})
  set_tests_properties(restart.${name} PROPERTIES
    PROCESSORS 3 TIMEOUT 240 LABELS "mpi;program;restart" ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
endfunction()

restart_test(strang bz-1d 7 method.name=strang method.step=1e-3 time.end=0.02)
restart_test(adaptive-strang bz-1d 17 method.name=adaptive-strang method.tolerance=1e-4 time.end=4e-3)
restart_test(dcs bz-1d 11 method.name=dcs method.tolerance=1e-6 time.end=8e-3)

same_bits_test(sbdf-1d bz-1d "${lines}" method.name=sbdf method.relative_tolerance=1e-4 time.end=0.02)
same_bits_test(sbdf-2d bz-2d-spiral "${boxes}" "grid.points=[67, 61]" method.name=sbdf method.relative_tolerance=1e-4 time.end=0.02)
same_bits_test(sbdf-custom ../../mpi-tests/driven_custom "${boxes}")
same_bits_test(adaptive-strang-custom ../../mpi-tests/driven_custom "${boxes}" method.name=adaptive-strang time.end=0.02)
same_bits_test(cvode bz-1d "${lines}" method.name=cvode time.end=0.01)
restart_test(sbdf bz-1d 37 method.name=sbdf method.relative_tolerance=1e-4 time.end=0.02)

# What the machine does to a run, and the model to its numbers.
function(fault_test name)
  add_test(NAME faults.${name} COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/faults/${name}.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE} ${ARGN})
  set_tests_properties(faults.${name} PROPERTIES LABELS fault PROCESSORS 2 TIMEOUT 240 ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
endfunction()
fault_test(numerics)
fault_test(files ${PROJECT_SOURCE_DIR}/drivers/cases/bz-1d.toml)
fault_test(stalls ${PROJECT_SOURCE_DIR}/drivers/cases/bz-1d.toml)
# A sample of the campaign; mpi-tests/nightly.sh has the rest.
fault_test(kills ${PROJECT_SOURCE_DIR}/drivers/cases/bz-1d.toml 4 method.name=adaptive-strang method.tolerance=1e-4 time.end=0.02)
same_bits_test(sdc-1d bz-1d "${lines}" method.name=sdc method.step=5e-4 time.end=0.01)
same_bits_test(sdc-adaptive-1d bz-1d "${lines}" method.name=sdc method.tolerance=1e-6 method.acceleration=true time.end=5e-3)
same_bits_test(sdc-dirichlet brusselator-1d "${lines}" method.name=sdc method.step=0.1 method.nodes=gauss-legendre time.end=1)
set(order_8 space.order=8 "grid.points=[61]")
same_bits_test(sdc-order-8 brusselator-1d "${lines}" ${order_8} method.name=sdc method.step=0.1 time.end=1)
same_bits_test(strang-order-8 brusselator-1d "${lines}" ${order_8} time.end=0.2)
same_bits_test(cvode-order-8 brusselator-1d "${lines}" ${order_8} "method={name=\"cvode\", linear_solver=\"gmres\"}" time.end=0.2)
same_bits_test(strang-2d-order-8 brusselator-2d "${boxes}" "grid.points=[47, 41]" space.order=8 method.name=strang method.step=0.05 time.end=0.1)
restart_test(sdc-order-8 brusselator-1d 3 ${order_8} method.name=sdc method.step=0.1 time.end=1)
restart_test(sdc bz-1d 7 method.name=sdc method.step=5e-4 time.end=0.01)
restart_test(sdc-adaptive bz-1d 11 method.name=sdc method.tolerance=1e-6 method.nodes=gauss-legendre time.end=4e-3)
same_bits_test(sdc-2d bz-2d-spiral "${boxes}" "grid.points=[67, 61]" method.name=sdc method.step=2e-3 time.end=0.01)
same_bits_test(sdc-2d-periodic brusselator-2d "1x1 4x1 1x4 2x2" "grid.points=[67, 61]" method.name=sdc method.step=0.02 time.end=0.1)
same_bits_test(sdc-2d-adaptive brusselator-2d "${boxes}" "grid.points=[67, 61]" method.name=sdc method.tolerance=1e-6 time.end=0.1)
restart_test(sdc-2d brusselator-2d 3 "grid.points=[35, 41]" method.name=sdc method.tolerance=1e-5 time.end=0.2)
same_bits_test(sdc-strang bz-1d "${lines}" method.name=sdc method.splitting=strang method.tolerance=1e-4 time.end=2e-3)
restart_test(sdc-strang bz-1d 5 method.name=sdc method.splitting=strang method.tolerance=1e-4 time.end=2e-3)
same_bits_test(sdc-diagonal bz-1d "${lines}" method.name=sdc method.splitting=diagonal method.tolerance=1e-9 time.end=5e-3)
same_bits_test(sdc-diagonal-2d bz-2d-spiral "${boxes}" "grid.points=[67, 61]" method.name=sdc method.splitting=diagonal method.step=1e-3 time.end=0.01)
restart_test(sdc-diagonal bz-1d 11 method.name=sdc method.splitting=diagonal method.tolerance=1e-9 time.end=5e-3)
# What auto takes is decided by the case alone.
same_bits_test(auto bz-1d "${lines}" "method={name=\"auto\", tolerance=1e-12}" time.end=2e-3)
restart_test(auto bz-1d 11 "method={name=\"auto\", tolerance=1e-12}" time.end=2e-3)
# Models with first derivatives.
same_bits_test(sdc-chemotaxis angiogenesis-chemotaxis-1d "${lines}" "grid.points=[101]" method.step=0.01 time.end=0.05)
same_bits_test(cvode-chemotaxis angiogenesis-chemotaxis-1d "${lines}" "grid.points=[101]" "method={name=\"cvode\"}" time.end=0.05)
same_bits_test(sdc-flame pulsating-flame-1d "${lines}" "grid.points=[401]" "grid.upper=[15]" method.step=1e-3 time.end=5e-3)
same_bits_test(strang-textbook pulsating-flame-1d "${lines}" "grid.points=[401]" "grid.upper=[15]" "method={name=\"strang\", step=1e-4}"
  diffusion_solver.name=crank-nicolson reaction_solver.name=trapezoidal time.end=1e-3)
restart_test(sdc-flame pulsating-flame-1d 3 "grid.points=[401]" "grid.upper=[15]" method.step=1e-3 time.end=1e-2)

# A sample of what mpi-tests/nightly.sh runs in full: up to eight ranks, balance of the reaction, depth of halos.
add_test(NAME same_bits.matrix
  COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/same_bits_matrix.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE} short)
set_tests_properties(same_bits.matrix PROPERTIES PROCESSORS 4 TIMEOUT 240 LABELS "mpi;program" ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
add_test(NAME program.counts
  COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/counts.sh $<TARGET_FILE:stiffront_program> ${MPIEXEC_EXECUTABLE})
set_tests_properties(program.counts PROPERTIES PROCESSORS 4 TIMEOUT 120 LABELS "mpi;program" ENVIRONMENT "${STIFFRONT_MPI_ENVIRONMENT}")
