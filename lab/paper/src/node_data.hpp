// Data of the study's networks: the database of a case, used as for the paper's networks.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness::study {

/// The rays of a database. Those of a linear body, which is solved in three directions and one step, are superposed to
/// 26 directions in six steps, because the training of networks needs points.
class NodeData {
 public:
  NodeData(const Database& database, bool superpose);
  const DatabaseHeader& header() const { return _header; }
  const TrainingTables& tables() const { return _tables; }
  /// @pre node is active
  const TouchedNodes& touched(std::int32_t node) const;
  std::vector<Ray> rays(std::int32_t node) const;

 private:
  const Database& _database;
  DatabaseHeader _header;
  TrainingTables _tables;
  bool _superpose;

  std::int32_t index_of(std::int32_t node) const;
};

}  // namespace phynness::study
