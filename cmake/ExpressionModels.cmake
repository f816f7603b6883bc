# One translation unit per number of species of models written in case files (max_custom_species in
# include/stiffront/solvers/custom_model.hpp).
foreach(N_SPECIES RANGE 1 8)
  set(source ${PROJECT_BINARY_DIR}/generated/models/expression_kernels_${N_SPECIES}.cpp)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/expression_kernels.cpp.in ${source} @ONLY)
  list(APPEND STIFFRONT_MODEL_SOURCES ${source})
  if(STIFFRONT_SANITIZE AND N_SPECIES GREATER 3)
    # One to two minutes each with sanitizers, for the templates that three species go through as well.
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -fno-sanitize=all)
  endif()
endforeach()
