# Every package from outside, each as one imported target.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(PkgConfig REQUIRED)

# Debian's single OpenCV modules come without a CMake package.
foreach(module core imgproc imgcodecs)
  if(NOT TARGET atropos::opencv_${module})
    find_path(ATROPOS_OPENCV_INCLUDE opencv2/${module}.hpp PATH_SUFFIXES opencv4 REQUIRED)
    find_library(ATROPOS_OPENCV_${module} opencv_${module} REQUIRED)
    add_library(atropos::opencv_${module} UNKNOWN IMPORTED)
    set_target_properties(atropos::opencv_${module} PROPERTIES IMPORTED_LOCATION ${ATROPOS_OPENCV_${module}})
    target_include_directories(atropos::opencv_${module} SYSTEM INTERFACE ${ATROPOS_OPENCV_INCLUDE})
  endif()
endforeach()

if(NOT ATROPOS_PACKAGES_TRACKER_ONLY)
  # The double build of Bullet: its .pc file carries BT_USE_DOUBLE_PRECISION, without which the libraries
  # still link and then misbehave. World checks sizeof(btScalar) at start-up.
  pkg_check_modules(BULLET REQUIRED IMPORTED_TARGET bullet-float64)
  add_library(atropos_bullet INTERFACE)
  add_library(atropos::bullet ALIAS atropos_bullet)
  target_link_libraries(atropos_bullet INTERFACE PkgConfig::BULLET)
  get_target_property(bullet_includes PkgConfig::BULLET INTERFACE_INCLUDE_DIRECTORIES)
  target_include_directories(atropos_bullet SYSTEM INTERFACE ${bullet_includes})

  find_package(assimp REQUIRED)
  find_package(yaml-cpp REQUIRED)
  find_package(fmt REQUIRED)
  find_package(CLI11 REQUIRED)
  find_package(nlohmann_json REQUIRED)
  find_package(Threads REQUIRED)
endif()

if(ATROPOS_TESTS)
  find_package(GTest REQUIRED)
  find_package(rapidcheck REQUIRED)
  include(GoogleTest)
endif()
if(ATROPOS_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
