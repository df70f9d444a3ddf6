# What an installation holds, and the Debian packages of it: spindle-twind (the daemon and what a service needs) and
# spindle-twin (host tool, spindles, documentation). `cpack --config build/CPackConfig.cmake` writes both;
# `tests/packages/run` builds, checks and installs them in a bare Debian.
include(GNUInstallDirs)
find_package(Python3 3.11 REQUIRED COMPONENTS Interpreter)
set(service ${PROJECT_SOURCE_DIR}/firmware/service)
set(packed ${PROJECT_BINARY_DIR}/packed)

# The installed configuration is the commented example with the places of a service.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/firmware/spindle-twind.example.toml
  ${PROJECT_SOURCE_DIR}/CHANGELOG.md)
file(READ ${PROJECT_SOURCE_DIR}/firmware/spindle-twind.example.toml config)
function(spindle_twin_in_service from to)
  string(FIND "${config}" "${from}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "cmake/packages.cmake: no \"${from}\" in firmware/spindle-twind.example.toml")
  endif()
  string(REPLACE "${from}" "${to}" config "${config}")
  set(config "${config}" PARENT_SCOPE)
endfunction()
spindle_twin_in_service("network = \"reference.rom\"      #" "network = \"network.rom\"        #")
spindle_twin_in_service("port = 1502                    # default 502, which needs CAP_NET_BIND_SERVICE"
  "port = 502                     # default; the service may listen there")
spindle_twin_in_service("# [history]\n# path = \"history.csv\"         #"
  "[history]\npath = \"/var/lib/spindle-twin/history.csv\"   #")
spindle_twin_in_service("# [checkpoint]                 #" "[checkpoint]                   #")
spindle_twin_in_service("# path = \"twin.checkpoint\"     #" "path = \"/var/lib/spindle-twin/twin.checkpoint\"   #")
file(WRITE ${packed}/twin.toml "${config}")

# Debian wants the changelog and manual pages compressed, without a time in them.
find_program(GZIP gzip REQUIRED)
function(spindle_twin_compress from to)
  execute_process(COMMAND ${GZIP} -9nc ${from} OUTPUT_FILE ${to} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
string(TIMESTAMP packed_on "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH where that is set
foreach(package spindle-twind spindle-twin)
  file(WRITE ${packed}/${package}/changelog "${package} (${PROJECT_VERSION}) stable; urgency=medium\n\n"
    "  * See CHANGELOG.md.gz beside this file.\n\n -- The spindle thermal twin authors <maintainers@spindle-twin.example>  ${packed_on}\n")
  file(WRITE ${packed}/${package}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n"
    "Upstream-Name: spindle-twin\n\nFiles: *\nCopyright: 2026 the spindle thermal twin authors\nLicense: Expat\n")
  file(STRINGS ${PROJECT_SOURCE_DIR}/LICENSE licence)
  foreach(line IN LISTS licence)
    if(NOT line MATCHES "^(MIT License|Copyright .*)$")
      file(APPEND ${packed}/${package}/copyright " ${line}\n")
    endif()
  endforeach()
  # The pages of both draw with uPlot.
  file(APPEND ${packed}/${package}/copyright "\nFiles: pages/uplot/*\nCopyright: 2022 Leon Sorokin\nLicense: Expat\n")
  spindle_twin_compress(${packed}/${package}/changelog ${packed}/${package}/changelog.gz)
  spindle_twin_compress(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${packed}/${package}/CHANGELOG.md.gz)
endforeach()
function(spindle_twin_manual file section component)
  get_filename_component(name ${file} NAME)
  file(MAKE_DIRECTORY ${packed}/manual)
  spindle_twin_compress(${file} ${packed}/manual/${name}.gz)
  install(FILES ${packed}/manual/${name}.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} COMPONENT ${component})
endfunction()

install(TARGETS spindle-twind RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT daemon)
install(FILES ${service}/spindle-twind.service DESTINATION /lib/systemd/system COMPONENT daemon)
install(FILES ${service}/spindle-twin.sysusers DESTINATION lib/sysusers.d RENAME spindle-twin.conf COMPONENT daemon)
install(FILES ${packed}/twin.toml DESTINATION /etc/spindle-twin COMPONENT daemon)
install(FILES ${service}/nftables.conf ${service}/real-time.conf
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twind/examples COMPONENT daemon)
install(FILES firmware/serve/registers.md firmware/serve/registers.csv SECURITY.md
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twind COMPONENT daemon)
install(FILES ${packed}/spindle-twind/copyright ${packed}/spindle-twind/changelog.gz ${packed}/spindle-twind/CHANGELOG.md.gz
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twind COMPONENT daemon)
spindle_twin_manual(${service}/spindle-twind.8 8 daemon)

install(TARGETS spindle-twin RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tools)
if(SPINDLE_TWIN_OFFLINE)
  install(TARGETS spindle-twin-fem RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR} COMPONENT tools)
endif()
install(DIRECTORY fem_offline/spindles DESTINATION ${CMAKE_INSTALL_DATADIR}/spindle-twin COMPONENT tools
  FILES_MATCHING PATTERN "*.toml")
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twin COMPONENT tools)
set(linuxcnc ${CMAKE_INSTALL_DATADIR}/doc/spindle-twin/examples/linuxcnc)  # where LinuxCNC runs is another computer
install(FILES host_tools/linuxcnc/README.md host_tools/linuxcnc/spindle_twin.hal host_tools/linuxcnc/spindle_twin.inc
  host_tools/linuxcnc/spindle_twin_mb2hal.ini DESTINATION ${linuxcnc} COMPONENT tools)
install(PROGRAMS host_tools/linuxcnc/spindle_twin_watch DESTINATION ${linuxcnc} COMPONENT tools)
file(GLOB plc_files CONFIGURE_DEPENDS host_tools/plc/*.md host_tools/plc/*.st host_tools/plc/*.scl host_tools/plc/*.[ch])
list(FILTER plc_files EXCLUDE REGEX "/(logic\\.st|reader_[a-z]+\\.(st|scl))$")  # what the others are made from
install(FILES ${plc_files} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twin/examples/plc COMPONENT tools)
install(FILES ${packed}/spindle-twin/copyright ${packed}/spindle-twin/changelog.gz ${packed}/spindle-twin/CHANGELOG.md.gz
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/spindle-twin COMPONENT tools)
spindle_twin_manual(${PROJECT_SOURCE_DIR}/host_tools/spindle-twin.1 1 tools)

# What is inside, as SPDX: after all else of the package is where it will be, programs stripped. No Debian file of its own
# may be missing from it, so it is made at the install, and only for a package: there all stands below DESTDIR.
function(spindle_twin_list_contents package program component)
  install(CODE "
    if(NOT \"\$ENV{DESTDIR}\" STREQUAL \"\")
      set(list /usr/share/doc/${package}/${package}.spdx.json)
      execute_process(COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/list_contents.py --build ${PROJECT_BINARY_DIR}
        --program ${program} --package ${package} --version ${PROJECT_VERSION} --root \$ENV{DESTDIR} -o \$ENV{DESTDIR}\${list}
        \${CMAKE_INSTALL_MANIFEST_FILES} COMMAND_ERROR_IS_FATAL ANY)
      list(APPEND CMAKE_INSTALL_MANIFEST_FILES \${list})
    endif()" COMPONENT ${component})
endfunction()
spindle_twin_list_contents(spindle-twind spindle-twind daemon)
if(SPINDLE_TWIN_OFFLINE)
  spindle_twin_list_contents(spindle-twin spindle-twin-fem tools)  # which has all that spindle-twin has
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "thermal digital twin of a machine tool spindle")
set(CPACK_PACKAGE_CONTACT "The spindle thermal twin authors <maintainers@spindle-twin.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL daemon)
if(SPINDLE_TWIN_OFFLINE)  # without its offline commands the host tool is no package
  list(APPEND CPACK_COMPONENTS_ALL tools)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_DAEMON_PACKAGE_NAME spindle-twind)
set(CPACK_DEBIAN_DAEMON_PACKAGE_SECTION science)
set(CPACK_DEBIAN_DAEMON_PACKAGE_DEPENDS "init-system-helpers (>= 1.62), systemd | systemd-standalone-sysusers | systemd-sysusers")
set(CPACK_COMPONENT_DAEMON_DESCRIPTION "Modbus/TCP daemon for an edge controller beside the machine.
Integrates the nodal network of a spindle once a second beside its machine,
corrects heat and contact resistance from a few temperature sensors, and
serves the growth of the spindle's nose with its uncertainty to the CNC.")
set(CPACK_DEBIAN_DAEMON_PACKAGE_CONTROL_EXTRA
  "${service}/postinst;${service}/prerm;${service}/postrm;${service}/conffiles")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME spindle-twin)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS "spindle-twind")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "Host tool.
Solves the finite element model of a spindle, reduces it to a nodal network
with a certificate of its error, inspects, exports and replays such networks.")
include(CPack)
