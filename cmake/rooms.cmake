# One library per folder and one test program per folder; a new file needs no edit of a list.
find_package(Eigen3 3.4 REQUIRED)
find_package(Threads REQUIRED)
find_package(nanopb 0.4.7 REQUIRED)
find_program(NANOPB_GENERATOR NAMES nanopb_generator nanopb_generator.py REQUIRED)

add_library(spindle_twin_flags INTERFACE)
target_include_directories(spindle_twin_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(spindle_twin_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wconversion;-Wno-sign-conversion;-Werror>)
# The same sums on every processor: GCC makes one operation with one rounding of a * b + c where the processor has it, and
# baseline x86-64 has none. A network written by hand is then the same file, to the bit, wherever it is assembled. Eigen's
# own products ask for that operation by themselves, and keep it.
if(NOT CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(spindle_twin_flags INTERFACE -ffp-contract=off)
endif()
if(SPINDLE_TWIN_SANITIZE)
  target_compile_options(spindle_twin_flags INTERFACE -fsanitize=${SPINDLE_TWIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # What the checks put in hides from GCC what was set before: std::regex is warned of (GCC's PR 105562). Without them the
  # same sources are compiled with this warning.
  target_compile_options(spindle_twin_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
  target_compile_definitions(spindle_twin_flags INTERFACE _GLIBCXX_ASSERTIONS)  # empty optionals, ends of vectors
  target_link_options(spindle_twin_flags INTERFACE -fsanitize=${SPINDLE_TWIN_SANITIZE})
  if(SPINDLE_TWIN_SANITIZE MATCHES "undefined")
    # This check opens a pipe to look at an object's memory. Tests leave a process without descriptors, and then it takes
    # every object for a broken one. The address sanitizer finds the use of an object after its end.
    target_compile_options(spindle_twin_flags INTERFACE -fno-sanitize=vptr)
    if(SPINDLE_TWIN_SANITIZE_NOT)
      target_compile_options(spindle_twin_flags INTERFACE -fno-sanitize=${SPINDLE_TWIN_SANITIZE_NOT})
    endif()
  endif()
endif()

# CMAKE_UNITY_BUILD: several sources of a folder in one go, for who builds once. A class whose parts stand in the unnamed
# namespace of its source is right, but the compiler takes that source for a header then.
if(CMAKE_UNITY_BUILD)
  # Of rooms and tests: what many of them instantiate is then compiled once. A release is also built on small machines: its
  # largest source would take 2.4 GB; those of the sanitizers' builds take 1.8.
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 24)
  if(SPINDLE_TWIN_SANITIZE)
    set(CMAKE_UNITY_BUILD_BATCH_SIZE 64)
  endif()
  target_compile_options(spindle_twin_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
endif()

# Precompiled headers halve the compiler's time. They hide a forgotten include, which the test `includes` finds instead.
option(SPINDLE_TWIN_PRECOMPILE "Precompiled headers (GCC only)" ON)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(SPINDLE_TWIN_PRECOMPILE OFF)
endif()
if(SPINDLE_TWIN_PRECOMPILE)
  # The compiler collects its garbage from 128 MB on, which a source with Eigen passes within a second.
  target_compile_options(spindle_twin_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=500000>)
  add_library(spindle_twin_eigen_kernels STATIC cmake/eigen_kernels.cpp)
  target_link_libraries(spindle_twin_eigen_kernels PRIVATE spindle_twin_flags Eigen3::Eigen)
  set_target_properties(spindle_twin_eigen_kernels PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(SPINDLE_TWIN_SANITIZE MATCHES "address")
    # Where tests spend much of their time. Accesses to memory are watched there too; Eigen's own arithmetic of indices is
    # not what is tested here.
    set_source_files_properties(cmake/eigen_kernels.cpp PROPERTIES COMPILE_OPTIONS "-O1;-fno-sanitize=undefined")
  endif()
endif()
set(spindle_twin_common_headers ${PROJECT_SOURCE_DIR}/cmake/eigen_kernels.hpp <algorithm> <array> <cmath> <cstdint> <cstdio>
  <filesystem> <fstream> <functional> <limits> <map> <memory> <numbers> <optional> <random> <set> <span> <sstream>
  <stdexcept> <string> <utility> <vector>)

# For sources whose programs are busy elsewhere: commands that read options and print, the daemon's main.cpp, and rooms that
# read, write, draw or serve. Tests take a quarter less time to compile with -Og, under which GCC calls variables uninitialized
# that are not.
set(spindle_twin_light $<$<CONFIG:Release>:-O1>)
set(spindle_twin_light_of_tests "$<$<CONFIG:Release>:-Og;-Wno-maybe-uninitialized>")

# spindle_twin_precompile(TARGET GROUP): the targets of a group share a precompiled header; they have the same compiler flags
# (GCC compiles with the optimization of the header, whatever the source's own command says). `rooms`, `light_rooms`,
# `tests`. It belongs to a target of its own, because a target waits for the whole of the one whose header it takes.
set(spindle_twin_headers_of_tests <gtest/gtest.h>)
function(spindle_twin_precompile target group)
  if(NOT SPINDLE_TWIN_PRECOMPILE)
    return()
  endif()
  set(owner spindle_twin_precompiled_${group})
  if(NOT TARGET ${owner})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/${owner}.cpp CONTENT "")
    add_library(${owner} OBJECT ${PROJECT_BINARY_DIR}/generated/${owner}.cpp)
    target_link_libraries(${owner} PRIVATE spindle_twin_flags Eigen3::Eigen)
    if(group STREQUAL "tests")
      target_link_libraries(${owner} PRIVATE GTest::gtest)
    endif()
    get_target_property(options ${target} COMPILE_OPTIONS)
    target_compile_options(${owner} PRIVATE ${options})
    target_precompile_headers(${owner} PRIVATE ${spindle_twin_common_headers} ${spindle_twin_headers_of_${group}})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
  target_link_libraries(${target} PRIVATE spindle_twin_eigen_kernels)
endfunction()

# spindle_twin_compile_as_light(TARGET): what reads, writes, draws or serves, and programs that start what is in the rooms.
# With CLI11 in the header each source would instantiate some of it at its end, two seconds in an empty one.
function(spindle_twin_compile_as_light target)
  target_compile_options(${target} PRIVATE ${spindle_twin_light} -fPIC -fno-semantic-interposition)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    spindle_twin_precompile(${target} light_rooms)
  else()
    spindle_twin_precompile(${target} rooms)
  endif()
endfunction()

function(spindle_twin_compile_as_room target)
  target_compile_options(${target} PRIVATE -fPIC -fno-semantic-interposition)
  spindle_twin_precompile(${target} rooms)
endfunction()

# spindle_twin_room(NAME [LIGHT] FOLDERS dir... [LINK lib...]): a static library of all C++ sources below the folders. Some
# also go into a shared library, where nothing is meant to be replaced at load time, so that calls within it may be inlined
# as in a program; all are compiled for that, and share a precompiled header. LIGHT: it reads, writes, draws or serves, and
# its sums are made in other rooms.
function(spindle_twin_room name)
  cmake_parse_arguments(ROOM "LIGHT" "" "FOLDERS;LINK" ${ARGN})
  set(sources "")
  foreach(folder IN LISTS ROOM_FOLDERS)
    file(GLOB_RECURSE found CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC spindle_twin_flags Eigen3::Eigen ${ROOM_LINK})
    if(ROOM_LIGHT)
      spindle_twin_compile_as_light(${name})
    else()
      spindle_twin_compile_as_room(${name})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE spindle_twin_flags Eigen3::Eigen ${ROOM_LINK})
  endif()
endfunction()

# All that sources include and the build makes, for who reads sources without compiling them all (tests/lint).
add_custom_target(spindle_twin_generated)

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
  add_dependencies(spindle_twin_generated ${name})
endfunction()

# A filter of GoogleTest for the tests that tests/long_tests names.
function(spindle_twin_long_tests filter)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/long_tests)
  file(STRINGS ${PROJECT_SOURCE_DIR}/tests/long_tests names REGEX "^[^#]")
  list(TRANSFORM names APPEND "*")
  list(JOIN names ":" names)
  set(${filter} "${names}" PARENT_SCOPE)
endfunction()

# Under the address sanitizer a program starts slowly: one process for all its tests, but the long ones. Not under the
# thread sanitizer: a test of the log leaves a thread behind that waits for its reader, as the daemon does when it ends.
function(spindle_twin_tests_in_one_process name)
  spindle_twin_long_tests(left_out)
  add_test(NAME ${name} COMMAND ${name} --gtest_brief=1 --gtest_filter=-${left_out})
  set_tests_properties(${name} PROPERTIES LABELS ${name} TIMEOUT 1800 FAIL_REGULAR_EXPRESSION "Running 0 tests")
endfunction()

# spindle_twin_keep_tests(TARGET PATTERN): leaves those tests in a program of which a line, or a line of what they include
# of ours, matches. For the programs of tests/run, where what is left out runs in another build.
function(spindle_twin_keep_tests target pattern)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(NOT source MATCHES "_test\\.cpp$")
      continue()
    endif()
    file(STRINGS ${source} matching REGEX "${pattern}" LIMIT_COUNT 1)
    file(STRINGS ${source} includes REGEX "^#include \"(tests|firmware)/")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^#include \"(.*)\".*$" "${PROJECT_SOURCE_DIR}/\\1" header "${include}")
      if(NOT matching AND EXISTS ${header})
        file(STRINGS ${header} matching REGEX "${pattern}" LIMIT_COUNT 1)
      endif()
    endforeach()
    if(NOT matching)
      list(REMOVE_ITEM sources ${source})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES SOURCES "${sources}")
endfunction()

# What begins a test of a suite that tests/long_tests names, for spindle_twin_keep_tests.
function(spindle_twin_suites_of_long_tests pattern)
  spindle_twin_long_tests(names)
  string(REPLACE ":" ";" suites "${names}")
  list(TRANSFORM suites REPLACE "^(.*/)?([A-Za-z0-9]+)\\..*$" "\\2")
  list(REMOVE_DUPLICATES suites)
  list(JOIN suites "|" suites)
  set(${pattern} "^TEST(_F|_P)?\\((${suites})," PARENT_SCOPE)
endfunction()

# spindle_twin_tests(NAME FOLDER [IN_ONE_PROCESS] [EXCEPT subfolder...] [LINK lib...] [TOGETHER suite...]): one GoogleTest
# program of all C++ files below FOLDER, but for subfolders that have their own; its ctest label is NAME. Every test is a
# process of its own, but the tests of a suite named TOGETHER share one, and with it what the suite prepares.
# IN_ONE_PROCESS: all do, because the program starts slowly (with deal.II it links some 200 libraries, 0.4 s).
function(spindle_twin_tests name folder)
  cmake_parse_arguments(TESTS "IN_ONE_PROCESS" "" "LINK;TOGETHER;EXCEPT" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  foreach(subfolder IN LISTS TESTS_EXCEPT)
    list(FILTER sources EXCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/${folder}/${subfolder}/")
  endforeach()
  if(sources)
    add_executable(${name} ${sources})
    target_link_libraries(${name} PRIVATE ${TESTS_LINK} spindle_twin_flags GTest::gtest GTest::gtest_main)
    target_compile_definitions(${name} PRIVATE SPINDLE_TWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    target_compile_options(${name} PRIVATE ${spindle_twin_light_of_tests})
    if(SPINDLE_TWIN_SANITIZE MATCHES "address")
      # Rooms are watched for the use of a variable after its scope. In tests, with the temporaries of every comparison,
      # that takes a fifth of the compiler's time and two fifths of the code.
      target_compile_options(${name} PRIVATE -fno-sanitize-address-use-after-scope)
    endif()
    spindle_twin_precompile(${name} tests)
    if(SPINDLE_TWIN_SANITIZE MATCHES "address")
      spindle_twin_tests_in_one_process(${name})
      return()
    elseif(TESTS_IN_ONE_PROCESS)
      add_test(NAME ${name} COMMAND ${name} --gtest_brief=1)
      set_tests_properties(${name} PROPERTIES LABELS ${name} TIMEOUT 1200 COST 100
        FAIL_REGULAR_EXPRESSION "Running 0 tests")
      return()
    endif()
    list(TRANSFORM TESTS_TOGETHER APPEND ".*" OUTPUT_VARIABLE elsewhere)
    list(JOIN elsewhere ":" elsewhere)
    if(SPINDLE_TWIN_SANITIZE)
      spindle_twin_long_tests(left_out)
      string(APPEND elsewhere ":${left_out}")
    endif()
    gtest_discover_tests(${name} TEST_FILTER "*-${elsewhere}" PROPERTIES LABELS ${name} TIMEOUT 600 DISCOVERY_TIMEOUT 60)
    foreach(suite IN LISTS TESTS_TOGETHER)
      add_test(NAME ${suite} COMMAND ${name} --gtest_filter=${suite}.*)
      set_tests_properties(${suite} PROPERTIES LABELS ${name} TIMEOUT 600 COST 100 FAIL_REGULAR_EXPRESSION "Running 0 tests")
    endforeach()
  endif()
endfunction()
