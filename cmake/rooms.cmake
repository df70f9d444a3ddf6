# One library per folder and one test program per folder; a new file needs no edit of a list.
find_package(Eigen3 3.4 REQUIRED)
find_package(Threads REQUIRED)
find_package(nanopb 0.4.7 REQUIRED)
find_program(NANOPB_GENERATOR NAMES nanopb_generator nanopb_generator.py REQUIRED)

add_library(spindle_twin_flags INTERFACE)
target_include_directories(spindle_twin_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(spindle_twin_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wconversion;-Wno-sign-conversion;-Werror>)
if(SPINDLE_TWIN_SANITIZE)
  target_compile_options(spindle_twin_flags INTERFACE -fsanitize=${SPINDLE_TWIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(spindle_twin_flags INTERFACE -fsanitize=${SPINDLE_TWIN_SANITIZE})
endif()

# spindle_twin_room(NAME DIR... [LINK lib...]): a static library of all C++ sources below the folders DIR.
function(spindle_twin_room name)
  cmake_parse_arguments(ROOM "" "" "FOLDERS;LINK" ${ARGN})
  set(sources "")
  foreach(folder IN LISTS ROOM_FOLDERS)
    file(GLOB_RECURSE found CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC spindle_twin_flags Eigen3::Eigen ${ROOM_LINK})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE spindle_twin_flags Eigen3::Eigen ${ROOM_LINK})
  endif()
endfunction()

# spindle_twin_schema(NAME PATH): PATH.proto below the sources as C structs, a library. Debian's nanopb package has no CMake
# function for this.
function(spindle_twin_schema name path)
  set(folder ${PROJECT_BINARY_DIR}/generated)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(OUTPUT ${folder}/${path}.pb.c ${folder}/${path}.pb.h
    COMMAND ${NANOPB_GENERATOR} --quiet --proto-path=${PROJECT_SOURCE_DIR} --output-dir=${folder} ${path}.proto
    DEPENDS ${PROJECT_SOURCE_DIR}/${path}.proto VERBATIM)
  add_library(${name} STATIC ${folder}/${path}.pb.c ${folder}/${path}.pb.h)
  target_include_directories(${name} SYSTEM PUBLIC ${folder})
  target_link_libraries(${name} PUBLIC nanopb::protobuf-nanopb-static)
endfunction()

# spindle_twin_tests(NAME FOLDER [LINK lib...]): one GoogleTest program of all C++ files below FOLDER; its ctest label is NAME.
function(spindle_twin_tests name folder)
  cmake_parse_arguments(TESTS "" "" "LINK" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  if(sources)
    add_executable(${name} ${sources})
    target_link_libraries(${name} PRIVATE ${TESTS_LINK} spindle_twin_flags GTest::gtest GTest::gtest_main)
    target_compile_definitions(${name} PRIVATE SPINDLE_TWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    gtest_discover_tests(${name} PROPERTIES LABELS ${name} TIMEOUT 600 DISCOVERY_TIMEOUT 60)
  endif()
endfunction()
