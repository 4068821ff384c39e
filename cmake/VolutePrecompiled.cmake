# With VOLUTE_PCH: what most sources include first is read once for the libraries and once for the tests. volute_math and its
# test own them: they come first of those that see Eigen; base goes without.
set(VOLUTE_PRECOMPILED <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <optional> <span> <string>
  <variant> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <nlohmann/json.hpp> <tl/expected.hpp>)

# volute_precompile(TARGET OWNER [HEADERS ..]): TARGET uses OWNER's, which are compiled where it is OWNER itself.
function(volute_precompile target owner)
  if(NOT VOLUTE_PCH OR target MATCHES "base")
    return()
  endif()
  if(target STREQUAL owner)
    target_precompile_headers(${target} PRIVATE ${VOLUTE_PRECOMPILED} ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${owner})
  endif()
endfunction()
