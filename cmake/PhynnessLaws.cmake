# Makes tables of laws and elements from laws/*.py when CMake runs and whenever one of these files
# changes. Only the standard library of Python is needed. The tables are not part of the repository, because they could then
# be out of date. Sets
#   PHYNNESS_LAWS_FOLDER   tables.cpp, compiled_forms.cpp and others, forms/*.py (described in laws/tables/tables.py)
#   PHYNNESS_LAWS          identifiers of the laws
#   PHYNNESS_SHELL_LAWS    shell_IDENTIFIER of the laws that have a shell
find_package(Python3 COMPONENTS Interpreter REQUIRED)
get_filename_component(law_folder ${CMAKE_CURRENT_LIST_DIR}/../laws ABSOLUTE)
file(GLOB law_files CONFIGURE_DEPENDS "${law_folder}/*.py")
file(GLOB law_tables "${law_folder}/tables/*.py")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${law_files} ${law_tables})
set(PHYNNESS_LAWS_FOLDER "${PROJECT_BINARY_DIR}/laws")
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 ${Python3_EXECUTABLE} "${law_folder}/tables/tables.py" "${PHYNNESS_LAWS_FOLDER}"
  OUTPUT_VARIABLE written ERROR_VARIABLE laws_error RESULT_VARIABLE laws_result OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT laws_result EQUAL 0)
  message(FATAL_ERROR "The tables of laws were not made: ${laws_error}")
endif()
string(REGEX MATCH "^([^\n]*)\n(.*)$" _ "${written}")
set(PHYNNESS_LAWS ${CMAKE_MATCH_1})
set(PHYNNESS_SHELL_LAWS ${CMAKE_MATCH_2})
