# atropos_module(NAME SOURCES ... [LINK ...] [PRIVATE_LINK ...])
# One library a folder: target atropos_NAME, alias atropos::NAME, includes rooted at the repository.
function(atropos_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(atropos_${name} STATIC ${ARG_SOURCES})
  add_library(atropos::${name} ALIAS atropos_${name})
  set_target_properties(atropos_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(atropos_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/atropos>)
  target_compile_features(atropos_${name} PUBLIC cxx_std_20)
  target_link_libraries(atropos_${name} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  atropos_warnings(atropos_${name})
  set_property(GLOBAL APPEND PROPERTY ATROPOS_MODULES atropos_${name})
endfunction()

# atropos_warnings(TARGET): on only when this is the top project, so that embedding stays quiet.
function(atropos_warnings target)
  if(PROJECT_IS_TOP_LEVEL)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      target_compile_options(${target} PRIVATE -Wno-restrict)  # false alarms on std::string's operator+ (GCC bug 105651)
    endif()
    if(ATROPOS_WERROR)
      target_compile_options(${target} PRIVATE -Werror)
    endif()
  endif()
endfunction()

# atropos_test(NAME LABEL label SOURCES ... LINK ...): one GoogleTest program whose cases ctest lists one by one.
function(atropos_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gmock_main rapidcheck rapidcheck_gtest)
  atropos_warnings(${name})
  gtest_discover_tests(${name} PROPERTIES LABELS "${ARG_LABEL}" DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)
endfunction()
