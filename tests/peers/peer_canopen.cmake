# cmake -DBOARDS=… -P peer_canopen.cmake: runs check_canopen.mjs; says what to do if the peers are not there.
find_program(node NAMES node nodejs)
if(NOT node OR NOT EXISTS ${CMAKE_CURRENT_LIST_DIR}/node_modules/canopen/package.json)
  message(FATAL_ERROR "The npm packages of tests/peers (or node itself) are not installed: run ./dev test, which "
                      "installs them, or npm ci --prefix tests/peers")
endif()
execute_process(COMMAND ${node} ${CMAKE_CURRENT_LIST_DIR}/check_canopen.mjs ${BOARDS} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "a CANopen master that nobody here wrote disagrees with our boards")
endif()
