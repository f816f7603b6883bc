# cmake -D CHECK=<CheckLayering.cmake> -D WORK=<scratch folder> -P layering_test.cmake
#
# The check is worth something only if it fails: builds small source trees, right and wrong, and looks at its verdict.
cmake_policy(VERSION 3.25)

function(expect verdict name pattern)  # then pairs: file, content
  set(root ${WORK}/${name})
  file(REMOVE_RECURSE ${root})
  while(ARGN)
    list(POP_FRONT ARGN path content)
    file(WRITE ${root}/${path} "${content}\n")
  endwhile()
  execute_process(COMMAND ${CMAKE_COMMAND} -D ROOT=${root} -P ${CHECK}
    RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(status EQUAL 0)
    set(got passes)
  else()
    set(got fails)
  endif()
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(NOT got STREQUAL verdict OR NOT output MATCHES "${pattern}")
    message(SEND_ERROR "${name}: expected that the check ${verdict} with '${pattern}', but it ${got}:\n${output}")
  endif()
endfunction()

expect(passes downward_include "2 files keep the layering"
  include/stiffront/core/a.hpp "#include <vector>"
  src/mesh/b.cpp "#include \"stiffront/core/a.hpp\"")
expect(fails upward_include "core includes upward from io: stiffront/io/b.hpp"
  include/stiffront/io/b.hpp ""
  src/core/a.cpp "  #  include \"stiffront/io/b.hpp\"")
expect(fails angle_bracket_upward_include "mesh includes upward from control"
  include/stiffront/mesh/a.hpp "#include <stiffront/control/b.hpp>")
expect(fails cycle_of_two "include cycle"
  include/stiffront/mesh/a.hpp "#include \"stiffront/mesh/b.hpp\""
  include/stiffront/mesh/b.hpp "#include \"stiffront/mesh/a.hpp\"")
expect(fails cycle_by_neighbour_path "include cycle"
  include/stiffront/mesh/a.hpp "#include \"b.hpp\""
  include/stiffront/mesh/b.hpp "#include \"c.hpp\""
  include/stiffront/mesh/c.hpp "#include \"stiffront/mesh/a.hpp\"")
expect(fails unknown_area "'utils' is not an area"
  include/stiffront/utils/a.hpp "")
expect(fails path_that_leaves_its_folder "leaves its folder"
  src/mesh/a.cpp "#include \"../io/b.hpp\"")
expect(fails nothing_to_check "no sources found"
  README "")
