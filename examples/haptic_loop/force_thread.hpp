// The work of a controller in each millisecond: position in, force out, without heap, locks or files.
#pragma once

#include <phynness/phynness.h>

#include "latest.hpp"
#include "touching_tool.hpp"
#include "vector3.hpp"

struct LoopSettings {
  double period_s = 1e-3;
  double coupling_stiffness_N_per_m = 400;  ///< between device and tool
  double coupling_damping_Ns_per_m = 0.6;
  double largest_damping_Ns_per_m = 20;  ///< of the passivity controller
  bool passivity_controller = true;
  long stale_cycles = 5;              ///< with older positions the force is 0
  double largest_displacement_m = 0;  ///< limit of the tool's displacement, such as the trained depth
};

/// State for the picture thread, small enough to be copied.
struct Touch {
  Vector3 displacement;   ///< of the tool, or of the node that it holds
  bool anywhere = false;  ///< contact anywhere on the surface, described by `held`
  phn_tool held{{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
  long cycle = 0;
};

class ForceThread {
 public:
  /// The tool holds active node `node`.
  ForceThread(const LoopSettings& settings, const phn_model* model, phn_data* data, int32_t node);
  /// The tool is a sphere that touches the surface. Only this thread may use `touching`.
  ForceThread(const LoopSettings& settings, const phn_model* model, TouchingTool& touching);

  /// @param position  of the device [m], relative to the first contact or in the frame of `touching`, measured in cycle
  ///                  `taken`
  /// @return force for the motors [N]; zero if the position is stale
  Vector3 step(Vector3 position, long taken, long cycle);

  Latest<Touch>& touch() { return _touch; }
  /// Work that the loop has taken from the hand [J]; a value below 0 is generated energy.
  double work() const { return _work; }
  /// Largest generated energy so far [J].
  double most_generated() const { return _most_generated; }
  long stale_cycles() const { return _stale; }
  long warnings() const { return _warnings; }

 private:
  /// Moves the tool between the spring of the coupling and the tissue: one Newton step of their equilibrium per cycle.
  void follow(Vector3 position);
  void follow_touching(Vector3 position);
  Vector3 kept_passive(Vector3 force, Vector3 moved);

  LoopSettings _settings;
  const phn_model* _model;
  phn_data* _data = nullptr;
  int32_t _node = -1;
  TouchingTool* _touching = nullptr;
  bool _has_stiffness = false;
  double _rest_stiffness[9] = {};  ///< for families without stiffness
  Latest<Touch> _touch;
  Vector3 _tool, _last_position, _last_force;
  bool _started = false;
  double _work = 0, _most_generated = 0;
  long _stale = 0, _warnings = 0;
};
