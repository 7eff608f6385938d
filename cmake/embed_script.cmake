# Writes OUTPUT with the text of each of FILES (comma-separated, below FOLDER). See embed.cmake.
string(REPLACE "," ";" FILES "${FILES}")
set(TEXT "#include \"host/embedded.hpp\"\n\nnamespace brdfit {\n\nextern const EmbeddedFile ${NAME}[];\nconst EmbeddedFile ${NAME}[] = {\n")
foreach(FILE ${FILES})
  file(READ ${FOLDER}/${FILE} CONTENT)
  string(APPEND TEXT "{\"${FILE}\", R\"EMBEDDED(${CONTENT})EMBEDDED\"},\n")
endforeach()
string(APPEND TEXT "{nullptr, nullptr}};\n\n} // namespace brdfit\n")
file(WRITE ${OUTPUT} "${TEXT}")
