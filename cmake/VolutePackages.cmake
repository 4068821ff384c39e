# Debian packages by CPack: ./dev package. A table of which component is in which package, and what packages say of themselves;
# the libraries that each needs are found by dpkg-shlibdeps.
set(VOLUTE_MAINTAINER "The Volute authors <volute@localhost.localdomain>" CACHE STRING "Of the .deb files")
set(release 1)
set(full ${PROJECT_VERSION}-${release})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME volute)
set(CPACK_PACKAGE_CONTACT "${VOLUTE_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${release})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_COMPONENTS_ALL)
# Else it would be the first line of every package's description.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")

# volute_deb(NAME SECTION SUMMARY TEXT COMPONENTS .. [LIBRARIES names] [DEPENDS ..] [RECOMMENDS ..] [SUGGESTS ..] [ALL])
set(packages "")
macro(volute_deb name section summary text)
  cmake_parse_arguments(P "ALL" "" "COMPONENTS;LIBRARIES;DEPENDS;RECOMMENDS;SUGGESTS" ${ARGN})
  string(REGEX REPLACE "[^a-z0-9]" "_" group ${name})
  string(TOUPPER ${group} GROUP)
  list(APPEND packages ${name})
  set(group_of_${name} ${group})
  set(components_of_${name} ${P_COMPONENTS})
  set(CPACK_DEBIAN_${GROUP}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${GROUP}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${GROUP}_DESCRIPTION "${summary}\n${text}")
  list(JOIN P_DEPENDS ", " depends)
  list(JOIN P_RECOMMENDS ", " recommends)
  list(JOIN P_SUGGESTS ", " suggests)
  set(CPACK_DEBIAN_${GROUP}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${GROUP}_PACKAGE_RECOMMENDS "${recommends}")
  set(CPACK_DEBIAN_${GROUP}_PACKAGE_SUGGESTS "${suggests}")
  if(P_ALL)
    set(CPACK_DEBIAN_${GROUP}_PACKAGE_ARCHITECTURE all)
    set(CPACK_DEBIAN_${GROUP}_PACKAGE_SHLIBDEPS OFF)
  endif()
  if(P_LIBRARIES)
    # ldconfig runs once after all packages are unpacked; who links with a library depends on just this version.
    set(folder ${PROJECT_BINARY_DIR}/deb/${name})
    list(TRANSFORM P_LIBRARIES REPLACE "(.+)" "\\1 ${VOLUTE_SOVERSION} ${name} (= ${full})\n" OUTPUT_VARIABLE lines)
    list(JOIN lines "" lines)
    file(WRITE ${folder}/shlibs "${lines}")
    file(WRITE ${folder}/triggers "activate-noawait ldconfig\n")
    set(CPACK_DEBIAN_${GROUP}_PACKAGE_CONTROL_EXTRA "${folder}/shlibs;${folder}/triggers")
  endif()
  # Each package has a copyright file and a changelog.
  foreach(component IN LISTS P_COMPONENTS)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    string(TOUPPER ${component} COMPONENT)
    set(CPACK_COMPONENT_${COMPONENT}_GROUP ${group})
  endforeach()
  list(GET P_COMPONENTS 0 first)
  install(FILES ${PROJECT_BINARY_DIR}/deb/copyright ${PROJECT_BINARY_DIR}/deb/changelog.Debian.gz
          DESTINATION share/doc/${name} COMPONENT ${first})
endmacro()

# What is loaded when it is first needed, and so seen by no dpkg-shlibdeps: libepoxy looks for these, which look for a driver.
set(openGl libegl1 libgl1 libgl1-mesa-dri)
set(idea "Volute measures, compresses, renders and looks through semi-transparent media:\nfire and smoke from cameras or simulations, and painted fog.")
volute_deb(libvolute-core0 libs "volumes in .volute files: library without pictures"
  "${idea}\nThis library reads and writes .volute files, holds volumes of voxels in memory,\nand reads results of the Fire Dynamics Simulator."
  COMPONENTS core LIBRARIES libvolute-core)
volute_deb(libvolute0 libs "fire, smoke and fog: library" "${idea}\nThis is all of the library, for C++ and for C."
  COMPONENTS shared c LIBRARIES libvolute libvolute_c RECOMMENDS fonts-dejavu-core ${openGl} "volute-vdb (= ${full})")
volute_deb(libvolute-dev libdevel "fire, smoke and fog: headers and static libraries"
  "${idea}\nThis package has what C++ and C programs are built with."
  COMPONENTS headers library shared-dev
  DEPENDS "libvolute0 (= ${full})" "libvolute-core0 (= ${full})" libtbb-dev libfmt-dev libexpected-dev libeigen3-dev libhwy-dev
    nlohmann-json3-dev libepoxy-dev libzstd-dev zlib1g-dev libpng-dev libyaml-dev libopenexr-dev libembree-dev libfreetype-dev libseccomp-dev
  SUGGESTS volute-doc)
volute_deb(volute graphics "fire, smoke and fog: the command"
  "${idea}\nThe command compresses volumes, reconstructs them from pictures, renders\nscenes and says from where exit signs are still seen."
  COMPONENTS command gltf tiff ocio RECOMMENDS fonts-dejavu-core fuse3 ${openGl} "volute-view (= ${full})" "volute-vdb (= ${full})" "volute-video (= ${full})"
  SUGGESTS "volute-vtk (= ${full})" volute-doc)
volute_deb(volute-view graphics "fire, smoke and fog: the viewer" "${idea}\nThis is the window that volute view opens."
  COMPONENTS viewer DEPENDS "volute (= ${full})" ${openGl})
volute_deb(volute-vdb graphics "fire, smoke and fog: OpenVDB files" "${idea}\nThis plug-in reads and writes OpenVDB files; volute mount shows .volute files\nas a folder of them."
  COMPONENTS vdb mount DEPENDS "volute (= ${full})" RECOMMENDS fuse3)
set(hdf5)
if(TARGET volute_hdf5)
  set(hdf5 hdf5)
endif()
volute_deb(volute-vtk graphics "fire, smoke and fog: VTK, EnSight, Exodus, OpenFOAM, netCDF, HDF5, Zarr"
  "${idea}\nThese plug-ins read meshes, lattices and arrays of CFD programs."
  COMPONENTS vtk gdal ${hdf5} DEPENDS "volute (= ${full})")
volute_deb(volute-video graphics "fire, smoke and fog: films" "${idea}\nThis plug-in reads and writes films."
  COMPONENTS video DEPENDS "volute (= ${full})")
if(TARGET volute_mpi)
  volute_deb(volute-mpi graphics "fire, smoke and fog: many machines" "${idea}\nThis plug-in lets mpirun share a command's work between machines."
    COMPONENTS mpi DEPENDS "volute (= ${full})" RECOMMENDS openmpi-bin)
endif()
if(TARGET volute-python)
  string(REGEX MATCH "[0-9]+$" minor ${VOLUTE_PYTHON_VERSION})
  math(EXPR next "${minor} + 1")
  set(python "python3 (>= ${VOLUTE_PYTHON_VERSION})" "python3 (<< 3.${next})")
  volute_deb(python3-volute python "volumes in .volute files as NumPy arrays"
    "${idea}\nThis package opens .volute files as lazy arrays and writes them."
    COMPONENTS python DEPENDS ${python} python3-numpy SUGGESTS "python3-volute-render (= ${full})" python3-dask python3-tqdm)
  volute_deb(python3-volute-render python "fire, smoke and fog from Python"
    "${idea}\nThis part renders scenes, looks along lines of sight, and reconstructs volumes\nfrom pictures."
    COMPONENTS python-render DEPENDS ${python} "python3-volute (= ${full})" RECOMMENDS "volute-vdb (= ${full})")
endif()
volute_deb(volute-doc doc "fire, smoke and fog: pages and examples" "${idea}\nThis package has its pages and examples."
  COMPONENTS docs ALL)

string(TIMESTAMP year "%Y" UTC)
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/deb/changelog.Debian CONTENT "volute (@full@) unstable; urgency=medium

  * Built by ./dev package; what changed is in CHANGELOG.md of volute-doc.

 -- @VOLUTE_MAINTAINER@  @now@
" @ONLY)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/deb/copyright CONTENT "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: volute

Files: *
Copyright: @year@ The Volute authors
License: Apache-2.0

License: Apache-2.0
 On Debian systems the whole text of the Apache License, version 2.0, is in
 /usr/share/common-licenses/Apache-2.0.
" @ONLY)
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/deb/changelog.Debian.gz
  COMMAND gzip -9nkf ${PROJECT_BINARY_DIR}/deb/changelog.Debian DEPENDS ${PROJECT_BINARY_DIR}/deb/changelog.Debian VERBATIM)
add_custom_target(volute-deb-files ALL DEPENDS ${PROJECT_BINARY_DIR}/deb/changelog.Debian.gz)

include(CPack)
