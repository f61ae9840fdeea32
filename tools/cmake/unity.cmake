# Compiles the sources of one folder as one, in all libraries and programs; the kernels are few and large, and
# sources with options of their own stay apart. Three
# quarters of the time to compile most sources go to the headers that they share. Names in unnamed namespaces
# must therefore be unique in their folder; those of a function may hide them, so that -Wshadow is for other builds.
function(scree_unite_directory directory)
  get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(NOT type MATCHES "^(EXECUTABLE|STATIC_LIBRARY|SHARED_LIBRARY)$")
      continue()
    endif()
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources INCLUDE REGEX "\\.cpp$")
    foreach(source IN LISTS sources)
      get_filename_component(source ${source} ABSOLUTE BASE_DIR ${directory})
      get_filename_component(folder ${source} DIRECTORY)
      string(REGEX REPLACE "[^A-Za-z0-9_]" "_" folder ${folder})
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${folder})
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  endforeach()
  get_property(subdirectories DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  foreach(subdirectory IN LISTS subdirectories)
    scree_unite_directory(${subdirectory})
  endforeach()
endfunction()

scree_unite_directory(${PROJECT_SOURCE_DIR})
