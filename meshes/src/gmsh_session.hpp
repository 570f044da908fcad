// The interface to gmsh: started and ended by an object, silent and reproducible; every error is an exception.
#pragma once

#include <functional>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// gmsh with an empty model and one thread, without console output and without the user's option files. Only one object
/// may exist at a time, because gmsh has global state.
class GmshSession {
 public:
  GmshSession();
  ~GmshSession();
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;

  /// Runs `work`. Any exception that it throws and any error that gmsh logs becomes a phynness::Error.
  void run(const std::string& what, const std::function<void()>& work) const;
  /// The tetrahedra of the current model and their nodes in the order of gmsh's numbers.
  RawMesh tetrahedra() const;
  /// The triangles of the current model and their nodes.
  RawMesh triangles() const;

 private:
  RawMesh elements(int type, const char* what) const;
};

}  // namespace phynness::meshes
