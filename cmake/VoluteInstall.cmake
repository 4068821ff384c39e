# What `cmake --install` puts where, by components: command, viewer, bench, docs; headers, library, shared, core, shared-dev, c;
# python, python-render; and a component for each
# plug-in (src/volute/io/CMakeLists.txt). docs/install.md says it for people.

# --- programs ---
install(TARGETS volute RUNTIME COMPONENT command)
if(TARGET volute-view)
  install(TARGETS volute-view RUNTIME COMPONENT viewer)
  install(FILES ${PROJECT_SOURCE_DIR}/apps/view/volute-view.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT viewer)
  install(FILES ${PROJECT_SOURCE_DIR}/apps/view/volute.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages COMPONENT viewer)
  install(FILES ${PROJECT_SOURCE_DIR}/apps/view/volute.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT viewer)
endif()
if(TARGET volute-mount)
  install(TARGETS volute-mount RUNTIME COMPONENT mount)
endif()
if(TARGET volute-bench)
  install(TARGETS volute-bench RUNTIME COMPONENT bench)
endif()
if(TARGET volute_bench_vtk)
  install(TARGETS volute_bench_vtk LIBRARY DESTINATION lib/volute COMPONENT bench)
endif()

# --- what the command says of itself ---
if(NOT CMAKE_CROSSCOMPILING)
  set(said ${PROJECT_BINARY_DIR}/said)
  file(MAKE_DIRECTORY ${said})
  add_custom_command(OUTPUT ${said}/volute.1 ${said}/volute ${said}/_volute ${said}/volute.fish
    COMMAND volute man > ${said}/volute.1
    COMMAND volute completion bash > ${said}/volute
    COMMAND volute completion zsh > ${said}/_volute
    COMMAND volute completion fish > ${said}/volute.fish
    DEPENDS volute VERBATIM)
  add_custom_command(OUTPUT ${said}/volute.1.gz COMMAND gzip -9nkf ${said}/volute.1 DEPENDS ${said}/volute.1 VERBATIM)
  set(manual ${said}/volute.1)
  if(VOLUTE_PACKAGES)
    set(manual ${said}/volute.1.gz)
  endif()
  add_custom_target(volute-manual ALL DEPENDS ${manual})
  install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
  install(FILES ${said}/volute DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT command)
  install(FILES ${said}/_volute DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT command)
  install(FILES ${said}/volute.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT command)
endif()

# --- pages ---
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)

# --- the library ---
# What comes from VOLUTE_DEPS_DIR is built in here and nowhere to be found for others.
if(VOLUTE_DEPS_DIR)
  message(STATUS "With VOLUTE_DEPS_DIR only programs are installed, no library")
  return()
endif()

# Public are the headers in include/volute/volute.hpp, what joins processes, the way to Eigen's types and, where OpenGL is, its
# renderer; and all that they include.
set(publicHeaders)
file(STRINGS include/volute/volute.hpp wanted REGEX "^#include \"volute/")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS include/volute/volute.hpp)
list(APPEND wanted "#include \"volute/cluster/cluster.hpp\"" "#include \"volute/math/eigen.hpp\"" "#include \"volute/math/rotation.hpp\""
     "#include \"volute/media/field_members.hpp\"")
if(VOLUTE_WITH_GL)
  list(APPEND wanted "#include \"volute/gl/gl_scene_renderer.hpp\"")
endif()
while(wanted)
  list(POP_FRONT wanted line)
  string(REGEX REPLACE "^#include \"(volute/.*)\".*" "\\1" header "${line}")
  if(header IN_LIST publicHeaders)
    continue()
  endif()
  list(APPEND publicHeaders ${header})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS src/${header})
  file(STRINGS src/${header} lines REGEX "^#include \"volute/")
  list(APPEND wanted ${lines})
endwhile()
foreach(header IN LISTS publicHeaders)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES src/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT headers)
endforeach()
install(FILES include/volute/volute.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/volute COMPONENT headers)

install(FILES include/volute/volute.h include/volute/medium.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/volute COMPONENT headers)
install(TARGETS volute_c LIBRARY COMPONENT c NAMELINK_COMPONENT headers)

# Modules that others may link with: what makes programs of them is no part of the library. In the order in which they were
# added, which is that of docs/layers.txt.
get_property(modules GLOBAL PROPERTY VOLUTE_MODULES)
list(REMOVE_ITEM modules cli viewer)
set(moduleTargets ${modules})
list(TRANSFORM moduleTargets PREPEND volute_)
install(TARGETS ${moduleTargets} EXPORT volute-targets ARCHIVE COMPONENT library
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

# volute_where(TARGET PACKAGE PC): how others find what a module links with: the arguments of find_dependency, or
# "NAME=module" of pkg-config, and what volute.pc says.
function(volute_where library package pc)
  set_property(GLOBAL PROPERTY "VOLUTE_PACKAGE_${library}" "${package}")
  set_property(GLOBAL PROPERTY "VOLUTE_PC_${library}" "${pc}")
endfunction()
volute_where(TBB::tbb "TBB CONFIG" tbb)
volute_where(fmt::fmt "fmt" fmt)
volute_where(tl::expected "tl-expected" "")
volute_where(Eigen3::Eigen "Eigen3 NO_MODULE" eigen3)
volute_where(hwy::hwy "hwy CONFIG" libhwy)
volute_where(ZLIB::ZLIB "ZLIB" zlib)
volute_where(PNG::PNG "PNG" libpng)
volute_where(nlohmann_json::nlohmann_json "nlohmann_json" nlohmann_json)
volute_where(OpenEXR::OpenEXR "OpenEXR CONFIG" OpenEXR)
volute_where(embree "embree ${VOLUTE_EMBREE} CONFIG" -lembree${VOLUTE_EMBREE})
volute_where(PkgConfig::ZSTD "ZSTD=libzstd" libzstd)
volute_where(PkgConfig::YAML "YAML=yaml-0.1" yaml-0.1)
volute_where(PkgConfig::FREETYPE "FREETYPE=freetype2" freetype2)
volute_where(PkgConfig::SECCOMP "SECCOMP=libseccomp" libseccomp)
volute_where(PkgConfig::EPOXY "EPOXY=epoxy" epoxy)
volute_where("${CMAKE_DL_LIBS}" "" "-l${CMAKE_DL_LIBS}")

# What each module is linked with, and all below it.
set(moduleTable)
set(pcRequires)
set(pcLibraries)
foreach(module IN LISTS modules)
  set(packages)
  get_target_property(libraries volute_${module} LINK_LIBRARIES)
  foreach(library IN LISTS libraries)
    if(library MATCHES "^volute::(.*)")
      list(APPEND packages ${packages_${CMAKE_MATCH_1}})
      continue()
    endif()
    get_property(known GLOBAL PROPERTY "VOLUTE_PACKAGE_${library}" SET)
    if(NOT known)
      message(FATAL_ERROR "volute_${module} links with ${library}: say by volute_where() how users of the installed library find it")
    endif()
    get_property(package GLOBAL PROPERTY "VOLUTE_PACKAGE_${library}")
    get_property(pc GLOBAL PROPERTY "VOLUTE_PC_${library}")
    list(APPEND packages ${package})
    if(pc MATCHES "^-")
      list(APPEND pcLibraries ${pc})
    else()
      list(APPEND pcRequires ${pc})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set(packages_${module} ${packages})
  string(APPEND moduleTable "set(_volute_packages_of_${module} \"${packages}\")\n")
endforeach()

# Static libraries are searched once, in order: who needs others comes before them.
set(archives ${modules})
list(REVERSE archives)
list(TRANSFORM archives PREPEND -lvolute_)
list(REMOVE_DUPLICATES pcRequires)
list(REMOVE_DUPLICATES pcLibraries)
list(JOIN pcRequires ", " pcRequires)
list(JOIN archives " " archives)
list(JOIN pcLibraries " " pcLibraries)
set(pcDefinitions)
if(VOLUTE_ASSERTS)
  list(APPEND pcDefinitions VOLUTE_ASSERTS)
endif()
list(TRANSFORM pcDefinitions PREPEND -D)
list(JOIN pcDefinitions " " pcDefinitions)
file(RELATIVE_PATH pcPrefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/volute-static.pc.in ${PROJECT_BINARY_DIR}/volute-static.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/volute-static.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)
configure_file(cmake/volute-c.pc.in ${PROJECT_BINARY_DIR}/volute-c.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/volute-c.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT headers)

set(configFolder ${CMAKE_INSTALL_LIBDIR}/cmake/volute)
if(VOLUTE_SHARED)
  include(VoluteShared)
endif()
set(sharedTable)
foreach(library core shared)
  string(APPEND sharedTable "set(_volute_packages_of_${library} \"${packages_${library}}\")\n")
endforeach()

include(CMakePackageConfigHelpers)
list(JOIN modules " " moduleNames)
configure_package_config_file(cmake/volute-config.cmake.in ${PROJECT_BINARY_DIR}/volute-config.cmake INSTALL_DESTINATION ${configFolder})
# Before 1.0 each minor version is another API.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/volute-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/volute-config.cmake ${PROJECT_BINARY_DIR}/volute-config-version.cmake
        DESTINATION ${configFolder} COMPONENT library)
install(EXPORT volute-targets NAMESPACE volute:: DESTINATION ${configFolder} COMPONENT library)
