# The target `one-definition`: a link of all modules, programs and plug-ins together that stops at types and functions with two
# definitions (-Wodr). It merges what the compiler knows of them (-flinker-output=rel) and makes no code: that takes seconds,
# where a whole link with -flto takes an hour.

function(volute_targets_below folder found)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below IN LISTS folders)
    volute_targets_below(${below} more)
    list(APPEND targets ${more})
  endforeach()
  set(${found} ${targets} PARENT_SCOPE)
endfunction()

set(objects)
foreach(folder src/volute bench apps/volute apps/view apps/mount)
  volute_targets_below(${PROJECT_SOURCE_DIR}/${folder} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(isLeftOut ${target} EXCLUDE_FROM_ALL)
    if(type MATCHES "^(STATIC_LIBRARY|MODULE_LIBRARY|EXECUTABLE)$" AND NOT isLeftOut)
      list(APPEND objects $<TARGET_OBJECTS:${target}>)
    endif()
  endforeach()
endforeach()
separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS}")
# Each program has its main(), each plug-in its own entry.
add_custom_target(one-definition VERBATIM COMMAND_EXPAND_LISTS
  COMMAND ${CMAKE_CXX_COMPILER} ${flags} -r -nostdlib -flinker-output=rel -Wl,-z,muldefs ${objects} -o one_definition.o
  DEPENDS ${objects})
