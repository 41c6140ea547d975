# Warnings are errors in our own code; dependencies are system headers.
add_library(annulus_warnings INTERFACE)
target_compile_options(annulus_warnings INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor
                       -Woverloaded-virtual -Wimplicit-fallthrough -Werror)
# Results must not depend on whether the compiler fuses a multiply and an add.
target_compile_options(annulus_warnings INTERFACE -ffp-contract=off)
target_include_directories(annulus_warnings INTERFACE ${CMAKE_SOURCE_DIR})

# annulus_library(<folder> SOURCES … PUBLIC libs… PRIVATE libs…): the one library of a folder.
function(annulus_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${folder} STATIC ${ARG_SOURCES})
  target_link_libraries(${folder} PUBLIC ${ARG_PUBLIC} PRIVATE annulus_warnings ${ARG_PRIVATE})
  target_include_directories(${folder} PUBLIC ${CMAKE_SOURCE_DIR})
endfunction()

# annulus_embed_text(<folder> <file> HEADER … FUNCTION …): the bytes of a file, in the folder's library, returned by a
# function that the header declares.
function(annulus_embed_text folder file)
  cmake_parse_arguments(ARG "" "HEADER;FUNCTION" "" ${ARGN})
  set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${file}.cpp)
  set(script ${CMAKE_SOURCE_DIR}/cmake/embed_text.cmake)
  add_custom_command(OUTPUT ${output} DEPENDS ${input} ${script} VERBATIM
    COMMAND ${CMAKE_COMMAND} -D INPUT=${input} -D OUTPUT=${output} -D HEADER=${ARG_HEADER} -D FUNCTION=${ARG_FUNCTION}
            -P ${script})
  target_sources(${folder} PRIVATE ${output})
endfunction()

# annulus_test(<folder> SOURCES … LIBS …): the one unit-test program of a folder, one CTest per program.
function(annulus_test folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${folder}_test ${ARG_SOURCES})
  target_link_libraries(${folder}_test PRIVATE annulus_warnings ${ARG_LIBS} test_folders GTest::gtest GTest::gmock
                        GTest::gtest_main)
  add_test(NAME unit_${folder} COMMAND ${folder}_test)
  set_tests_properties(unit_${folder} PROPERTIES TIMEOUT 600
                       ENVIRONMENT "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/support/lsan.supp:print_suppressions=0")
endfunction()

# annulus_threads_test(<folder> <filter>): the tests of a folder that run threads, for the thread sanitizer only.
function(annulus_threads_test folder filter)
  if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
    add_test(NAME threads_${folder} COMMAND ${folder}_test --gtest_filter=${filter})
    set_tests_properties(threads_${folder} PROPERTIES TIMEOUT 900 LABELS threads)
  endif()
endfunction()

# All fuzz targets at once.
if(ANNULUS_FUZZ)
  add_custom_target(fuzz_targets)
endif()

# annulus_fuzz(<name> SOURCES … LIBS …): a libFuzzer target with its corpus in tests/fuzz/corpus/<name>.
function(annulus_fuzz name)
  if(NOT ANNULUS_FUZZ)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(fuzz_${name} ${ARG_SOURCES})
  target_link_libraries(fuzz_${name} PRIVATE annulus_warnings ${ARG_LIBS})
  target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzz_targets fuzz_${name})
endfunction()
