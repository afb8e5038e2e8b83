# Tests of the program as a user runs it, of scripts and of pages; tests/CMakeLists.txt includes this file.
add_test(NAME layering COMMAND ${PROJECT_SOURCE_DIR}/tests/layering.py ${PROJECT_SOURCE_DIR})
add_test(NAME layering_self_test COMMAND ${PROJECT_SOURCE_DIR}/tests/layering.py --self-test)
add_test(NAME scaling COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_scaling.py)
add_test(NAME spack COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_spack.py)
add_test(NAME plot_series COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_plot_series.py)
add_test(NAME setup COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_setup.py ${CMAKE_COMMAND})
set_tests_properties(layering layering_self_test plot_series scaling setup spack PROPERTIES TIMEOUT 300 LABELS script)

# The whole program, as a user runs it.
set(program_tests golden program threads inputs jets bad_flow bad_input stability documents pages trevi_run)
if(TREVI_WITH_VTK)
  list(APPEND program_tests pictures)
endif()
foreach(name IN LISTS program_tests)
  add_test(NAME ${name} COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_${name}.py $<TARGET_FILE:trevi>
                                ${MPIEXEC_EXECUTABLE})
  set_tests_properties(${name} PROPERTIES TIMEOUT 300 PROCESSORS 2 LABELS program SKIP_RETURN_CODE 77)
endforeach()
if(TARGET trevi_python)
  foreach(name python python_misuse python_solids notebooks studies)
    add_test(NAME ${name} COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_${name}.py $<TARGET_FILE:trevi>
                                  ${MPIEXEC_EXECUTABLE})
    set_tests_properties(${name} PROPERTIES TIMEOUT 300 PROCESSORS 2 LABELS program
      ENVIRONMENT "TREVI_PYTHON=${PROJECT_BINARY_DIR}/python")
  endforeach()
endif()
set_tests_properties(golden PROPERTIES TIMEOUT 1200)  # 80 runs or more: ranks x threads x instruction sets
set_tests_properties(inputs PROPERTIES TIMEOUT 600)  # 15 runs to their end
# What jobs/test.sh --quick runs: all unit tests, all MPI tests on one rank, and the bits of three scenes on one set.
add_test(NAME golden_quick COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_golden.py $<TARGET_FILE:trevi>
                                   ${MPIEXEC_EXECUTABLE})
set_tests_properties(golden_quick PROPERTIES TIMEOUT 300 PROCESSORS 2 LABELS "program;quick" ENVIRONMENT
  "TREVI_GOLDEN_ONE_SET=1;TREVI_GOLDEN_CASES=falling_cube_small dam_break_obstacle_small trevi_fountain_small")
# The library from outside: an install tree, find_package(Trevi), a program of a few lines.
add_test(NAME embed
         COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_embed.py ${PROJECT_BINARY_DIR} ${MPIEXEC_EXECUTABLE}
                 --cmake ${CMAKE_COMMAND} --compiler ${CMAKE_CXX_COMPILER} --flags=${CMAKE_CXX_FLAGS})
set_tests_properties(embed PROPERTIES PROCESSORS 2 TIMEOUT 300 LABELS program)
if(TREVI_WITH_MUSIC)
  add_test(NAME music_run
           COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_music_run.py $<TARGET_FILE:trevi> ${MPIEXEC_EXECUTABLE})
  set_tests_properties(music_run PROPERTIES PROCESSORS 2 TIMEOUT 300 LABELS script)
endif()
# Runs of the real program that are killed, stopped, starved and restarted.
foreach(subject Restart SceneChanges Signals Kill Failures TwoRuns Slurm)
  set(script survival)
  if(subject MATCHES "Restart|SceneChanges")
    set(script restart)
  endif()
  add_test(NAME survival_${subject} COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_${script}.py ${subject})
  # They mostly wait, so two of them may run side by side.
  set_tests_properties(survival_${subject} PROPERTIES PROCESSORS 1 TIMEOUT 600 LABELS survival
    ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;MPIEXEC=${MPIEXEC_EXECUTABLE}")
endforeach()
add_test(NAME bad_files COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_bad_files.py)
set_tests_properties(bad_files PROPERTIES PROCESSORS 1 TIMEOUT 900 LABELS survival
  ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;MPIEXEC=${MPIEXEC_EXECUTABLE}")

# A disk that is not well, a rank that is lost, a clock that jumps.
add_library(fault_shim SHARED regression/fault_shim.cpp)
target_compile_features(fault_shim PRIVATE cxx_std_20)
# Without libmpi itself, as mpirun is preloaded with it, too; calls are bound when they are made.
target_include_directories(fault_shim SYSTEM PRIVATE ${MPI_CXX_INCLUDE_DIRS})
target_link_libraries(fault_shim PRIVATE ${CMAKE_DL_LIBS})
target_link_options(fault_shim PRIVATE -Wl,-z,lazy)
add_test(NAME faults COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_faults.py $<TARGET_FILE:fault_shim>)
set_tests_properties(faults PROPERTIES PROCESSORS 1 TIMEOUT 600 LABELS survival
  ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;MPIEXEC=${MPIEXEC_EXECUTABLE}")

add_test(NAME endurance COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_endurance.py)
set_tests_properties(endurance PROPERTIES PROCESSORS 2 TIMEOUT 600 LABELS survival
  ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;MPIEXEC=${MPIEXEC_EXECUTABLE}")

# Where ParaView is installed and jobs/paraview_modules.sh has been run; else it says what it misses.
add_test(NAME paraview COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_paraview.py)
set_tests_properties(paraview PROPERTIES PROCESSORS 2 TIMEOUT 600 LABELS view SKIP_RETURN_CODE 77
  ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;MPIEXEC=${MPIEXEC_EXECUTABLE}")

# The viewer, in a window on a screen of its own.
find_program(XVFB Xvfb)
find_program(XDOTOOL xdotool)
if(TARGET trevi-view AND XVFB AND XDOTOOL)
  set(view_tests view)
  if(TREVI_WITH_LIVE)
    list(APPEND view_tests view_live)
  endif()
  foreach(name IN LISTS view_tests)
    add_test(NAME ${name} COMMAND ${PROJECT_SOURCE_DIR}/tests/regression/test_${name}.py)
    set_tests_properties(${name} PROPERTIES PROCESSORS 2 TIMEOUT 600 LABELS view
      ENVIRONMENT "TREVI=$<TARGET_FILE:trevi>;TREVI_VIEW=$<TARGET_FILE:trevi-view>;MPIEXEC=${MPIEXEC_EXECUTABLE}")
  endforeach()
else()
  message(STATUS "the tests of trevi-view are left out: they need the viewer, Xvfb and xdotool")
endif()

if(TREVI_FUZZ)
  set(fuzzed scene checkpoint)
  if(TREVI_WITH_LIVE)
    list(APPEND fuzzed messages)
  endif()
  if(TREVI_WITH_MUSIC)
    list(APPEND fuzzed music)
  endif()
  foreach(subject IN LISTS fuzzed)
    add_executable(fuzz_${subject} EXCLUDE_FROM_ALL regression/fuzz_${subject}.cpp)
    target_link_libraries(fuzz_${subject} PRIVATE trevi_app trevi_private trevi_rules PkgConfig::HDF5)
    target_link_options(fuzz_${subject} PRIVATE -fsanitize=fuzzer)
  endforeach()
endif()
# The longest start first, also where ctest has not seen them run.
set_tests_properties(golden PROPERTIES COST 500)
set_tests_properties(survival_Restart bad_files bad_flow bad_input survival_Kill inputs faults PROPERTIES COST 100)
