# find_package(arbox COMPONENTS ...) for other projects.
include(CMakePackageConfigHelpers)
get_property(arbox_components GLOBAL PROPERTY arbox_components)
get_property(arbox_component_table GLOBAL PROPERTY arbox_component_table)
configure_package_config_file(cmake/arboxConfig.cmake.in "${CMAKE_BINARY_DIR}/arboxConfig.cmake"
  INSTALL_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/arbox")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/arboxConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/arboxConfig.cmake" "${CMAKE_BINARY_DIR}/arboxConfigVersion.cmake"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/arbox" COMPONENT base)
