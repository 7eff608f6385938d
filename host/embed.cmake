# embed_files(NAME FOLDER FILE...): sets NAME to a generated source file that defines
#   const brdfit::EmbeddedFile brdfit::NAME[], ended by an entry without a name (host/embedded.hpp).
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})
  function(embed_files NAME FOLDER)
    set(OUTPUT ${PROJECT_BINARY_DIR}/${NAME}.cpp)
    list(TRANSFORM ARGN PREPEND ${FOLDER}/ OUTPUT_VARIABLE PATHS)
    string(REPLACE ";" "," FILES "${ARGN}")
    add_custom_command(OUTPUT ${OUTPUT}
      COMMAND ${CMAKE_COMMAND} -DNAME=${NAME} -DFOLDER=${FOLDER} -DFILES=${FILES} -DOUTPUT=${OUTPUT}
              -P ${EMBED_SCRIPT}
      DEPENDS ${PATHS} ${EMBED_SCRIPT} VERBATIM)
    set(${NAME} ${OUTPUT} PARENT_SCOPE)
  endfunction()
  return()
endif()

# As a script: writes OUTPUT with the text of each of FILES (comma-separated, below FOLDER).
string(REPLACE "," ";" FILES "${FILES}")
set(TEXT "#include \"host/embedded.hpp\"\n\nnamespace brdfit {\n\nextern const EmbeddedFile ${NAME}[];\nconst EmbeddedFile ${NAME}[] = {\n")
foreach(FILE ${FILES})
  file(READ ${FOLDER}/${FILE} CONTENT)
  string(APPEND TEXT "{\"${FILE}\", R\"EMBEDDED(${CONTENT})EMBEDDED\"},\n")
endforeach()
string(APPEND TEXT "{nullptr, nullptr}};\n\n} // namespace brdfit\n")
file(WRITE ${OUTPUT} "${TEXT}")
