# cmake -DWRITER=… -DFOLDER=… -P peer_mcap.cmake: runs check_recording.mjs; says what to do if the peers are not there.
find_program(node NAMES node nodejs)
if(NOT node OR NOT EXISTS ${CMAKE_CURRENT_LIST_DIR}/node_modules/@mcap/core/package.json)
  message(FATAL_ERROR "The npm packages of tests/peers (or node itself) are not installed: run ./dev test, which "
                      "installs them, or npm ci --prefix tests/peers")
endif()
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
execute_process(COMMAND ${node} ${CMAKE_CURRENT_LIST_DIR}/check_recording.mjs ${WRITER} ${FOLDER} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "the official reader disagrees with our recording")
endif()
