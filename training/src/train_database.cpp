// Training on a database.
#include <phynness/formats/error.hpp>
#include <phynness/training/training.hpp>

namespace phynness {

ResponseSource responses_of(const Database& database) {
  const Scene scene = stored_scene(database.header());
  ResponseSource source;
  source.header = &database.header();
  source.rays = [&database](std::int32_t active) { return database.rays(active); };
  source.probe = scene.probe;
  source.spreads = spreads(scene.active);
  source.title = scene.title;
  return source;
}

Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress, int threads) {
  const Law law = stored_scene(database.header()).material.law;
  // Whether imported responses are linear, their numbers tell.
  if (schema::traits(spec.family).proportional && !law->linear && !database.header().is_imported()) {
    throw input_error("family linear needs the linear law", std::string("law ") + name(law),
                      "use family modal or rbfn");
  }
  return train(responses_of(database), spec, report, progress, threads);
}

}  // namespace phynness
