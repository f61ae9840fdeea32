# The evaluator, which the tests check and the scene benchmark uses.
if(NOT TARGET scree_bench_evaluator)
  add_library(scree_bench_evaluator STATIC ${PROJECT_SOURCE_DIR}/bench/evaluate.cpp
    ${PROJECT_SOURCE_DIR}/bench/geometry.cpp ${PROJECT_SOURCE_DIR}/bench/polytope.cpp
    ${PROJECT_SOURCE_DIR}/bench/surface.cpp
    ${PROJECT_SOURCE_DIR}/bench/scenes/step_times.cpp)
  target_link_libraries(scree_bench_evaluator PUBLIC scree_scenes scree_flags Eigen3::Eigen)
endif()
