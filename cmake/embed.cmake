# SPDX-License-Identifier: BSD-3-Clause
# cmake -DOUTPUT=FILE.cpp -DNAME=name -DBEFORE=TEXT -DAFTER=TEXT -DFILES=a|b -P embed.cmake
# Writes the contents of the files, each between BEFORE and AFTER, as one string: mapjoin::apps::embedded::name.
string(REPLACE "|" ";" files "${FILES}")
set(literals "")
foreach(file IN LISTS files)
  file(READ "${file}" text)
  string(APPEND literals "R\"~embedded~(${BEFORE}${text}${AFTER})~embedded~\"\n")
endforeach()
file(WRITE "${OUTPUT}"
  "#include <string_view>\n"
  "namespace mapjoin::apps::embedded {\n"
  "extern const std::string_view ${NAME};\n"
  "const std::string_view ${NAME} =\n${literals};\n"
  "}  // namespace mapjoin::apps::embedded\n")
