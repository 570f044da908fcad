// Training on a database.
#include <phynness/formats/error.hpp>
#include <phynness/training/training.hpp>

namespace phynness {

Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress, int threads) {
  const DatabaseHeader& header = database.header();
  const Scene scene = stored_scene(header);
  if (schema::traits(spec.family).proportional && !scene.material.law->linear) {
    throw input_error("family linear needs the linear law", std::string("law ") + name(scene.material.law),
                      "use family modal or rbfn");
  }
  ResponseSource source;
  source.header = &header;
  source.rays = [&](std::int32_t active) { return database.rays(active); };
  source.probe = scene.probe;
  source.spreads = spreads(scene.active);
  source.title = scene.title;
  return train(source, spec, report, progress, threads);
}

}  // namespace phynness
