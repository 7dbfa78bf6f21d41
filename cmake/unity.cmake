# Unity builds: sources of a folder are compiled several at a time, which reads their headers once.
# Most of a source's time goes into headers (nlohmann/json, CLI11, fmt), so this halves a build from
# nothing. Not for what is timed: what a compiler inlines there must not depend on neighbours.
#
# Off (-DCVRBENCH_UNITY=OFF), each source is compiled alone: a change in one is then built faster, and
# one that leans on its neighbour's includes or names shows: scripts/tidy --alone.
option(CVRBENCH_UNITY "Compile several sources of a folder at a time" ON)

# cvr_unity(TARGET SIZE FOLDER...): groups of at most SIZE sources of one of the folders, all of about
# one size.
function(cvr_unity target size)
  if(NOT CVRBENCH_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  list(SORT sources)
  set(folders "")
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE)
    get_filename_component(folder ${path} DIRECTORY)
    file(RELATIVE_PATH folder ${CMAKE_CURRENT_SOURCE_DIR} ${folder})
    if(NOT folder IN_LIST ARGN)
      continue()
    endif()
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    list(APPEND folders ${folder})
    list(APPEND of_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder ${folders})
    list(LENGTH of_${folder} count)
    math(EXPR groups "(${count} + ${size} - 1) / ${size}")
    set(at 0)
    foreach(source ${of_${folder}})
      math(EXPR group "${at} * ${groups} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${group})
      math(EXPR at "${at} + 1")
    endforeach()
  endforeach()
endfunction()
