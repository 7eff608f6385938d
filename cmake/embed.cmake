# embed_files(NAME FOLDER FILE...): sets NAME to a generated source file that defines
#   const brdfit::EmbeddedFile brdfit::NAME[], ended by an entry without a name (host/embedded.hpp).
function(embed_files NAME FOLDER)
  set(OUTPUT ${PROJECT_BINARY_DIR}/${NAME}.cpp)
  set(PATHS)
  foreach(FILE ${ARGN})
    list(APPEND PATHS ${FOLDER}/${FILE})
  endforeach()
  string(REPLACE ";" "," FILES "${ARGN}")
  add_custom_command(OUTPUT ${OUTPUT}
    COMMAND ${CMAKE_COMMAND} -DNAME=${NAME} -DFOLDER=${FOLDER} -DFILES=${FILES} -DOUTPUT=${OUTPUT}
            -P ${PROJECT_SOURCE_DIR}/cmake/embed_script.cmake
    DEPENDS ${PATHS} ${PROJECT_SOURCE_DIR}/cmake/embed_script.cmake VERBATIM)
  set(${NAME} ${OUTPUT} PARENT_SCOPE)
endfunction()
