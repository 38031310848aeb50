# The double build of Bullet: its .pc file carries BT_USE_DOUBLE_PRECISION, without which the libraries still link and
# then misbehave. World checks sizeof(btScalar) at start-up.
if(NOT TARGET atropos::bullet)
  pkg_check_modules(ATROPOS_BULLET REQUIRED bullet-float64)
  add_library(atropos::bullet INTERFACE IMPORTED GLOBAL)
  set_target_properties(atropos::bullet PROPERTIES
    INTERFACE_COMPILE_OPTIONS "${ATROPOS_BULLET_CFLAGS_OTHER}"
    INTERFACE_LINK_LIBRARIES "${ATROPOS_BULLET_LINK_LIBRARIES}")
  target_include_directories(atropos::bullet SYSTEM INTERFACE ${ATROPOS_BULLET_INCLUDE_DIRS})
endif()
