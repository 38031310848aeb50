# Program, libraries, headers, data, and a package that `find_package(atropos)` finds. The tracker can be used alone:
# finding the package asks for what the components named need, nothing else.
get_property(modules GLOBAL PROPERTY ATROPOS_MODULES)
install(TARGETS ${modules} EXPORT atroposTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS atropos RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT atroposTargets NAMESPACE atropos:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/atropos)
foreach(folder scenes tracker robot sim render experiments)
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/atropos FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/atropos
  FILES_MATCHING PATTERN "*.yaml" PATTERN "*.obj" PATTERN "*.mtl" PATTERN "*.png")

configure_package_config_file(cmake/atroposConfig.cmake.in ${PROJECT_BINARY_DIR}/atroposConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/atropos)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/atroposConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/atroposConfig.cmake ${PROJECT_BINARY_DIR}/atroposConfigVersion.cmake
  cmake/OpenCvModules.cmake cmake/BulletDouble.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/atropos)
