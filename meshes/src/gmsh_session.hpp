// The only door to gmsh: started and ended as an object, silent, reproducible, every error an exception.
#pragma once

#include <functional>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// gmsh with an empty model, one thread, no console output, without the user's option files.
/// One at a time: gmsh is a process-wide library.
class GmshSession {
 public:
  GmshSession();
  ~GmshSession();
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;

  /// Runs `work`; whatever it throws, and whatever gmsh logs as an error on the way, becomes one
  /// phynness::Error.
  void run(const std::string& what, const std::function<void()>& work) const;
  /// The tetrahedra of the current model and their nodes in the order of gmsh's numbers.
  RawMesh tetrahedra() const;
  /// The same of its triangles.
  RawMesh triangles() const;

 private:
  RawMesh elements(int type, const char* what) const;
};

}  // namespace phynness::meshes
