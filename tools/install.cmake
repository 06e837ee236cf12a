# `cmake --install`: the tools, their man pages and completions (both made from --help), scenes, licence.
include(GNUInstallDirs)
find_program(PRECIS_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)  # not one that a user's PATH puts first
find_program(PRECIS_PYTHON python3 REQUIRED)
get_property(precis_tools GLOBAL PROPERTY PRECIS_TOOLS)

set(docs ${CMAKE_BINARY_DIR}/docs)
set(pages "")
foreach(tool IN LISTS precis_tools)
  add_custom_command(
    OUTPUT ${docs}/man/${tool}.1 ${docs}/bash/${tool} ${docs}/zsh/_${tool} ${docs}/fish/${tool}.fish
    COMMAND ${PRECIS_PYTHON} ${CMAKE_SOURCE_DIR}/tools/make_docs.py $<TARGET_FILE:${tool}> -o ${docs}
    DEPENDS ${tool} ${CMAKE_SOURCE_DIR}/tools/make_docs.py
    COMMENT "Man page and completions of ${tool}" VERBATIM)
  list(APPEND pages ${docs}/man/${tool}.1)
  install(TARGETS ${tool} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(FILES ${docs}/man/${tool}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${docs}/bash/${tool} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${docs}/zsh/_${tool} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${docs}/fish/${tool}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endforeach()
add_custom_target(docs ALL DEPENDS ${pages})

install(FILES LICENSE README.md CITATION.cff lib/references.bib DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES lib/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME conventions.md)
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/precis
        FILES_MATCHING PATTERN "*.yaml" PATTERN "*.json" PATTERN "slurm" EXCLUDE)
