#!/bin/sh
# Claim: what cmake --install lays down works in any folder, without the build: the command meshes a shape with gmsh and
# starts the program with the solver, and says what is missing when one of them is.
# Usage: installed_command_works.sh CMAKE BUILD WORK SCENE
set -eu
cmake=$1 build=$2 work=$3 scene=$4
rm -rf "$work"
for part in cli meshes; do
  "$cmake" -DCMAKE_INSTALL_PREFIX="$work/first" -P "$build/$part/cmake_install.cmake" >/dev/null
done
mv "$work/first" "$work/moved"
"$work/moved/bin/phynness" mesh "$scene" -o "$work/mesh.msh"
grep -q MeshFormat "$work/mesh.msh"
"$work/moved/bin/phynness" --version
rm "$work/moved/bin/phynness-solver"
! "$work/moved/bin/phynness" check "$scene" 2>"$work/error"
grep -q "solver cannot be started.*bin/phynness-solver" "$work/error"
find "$work/moved" -name phynness_gmsh.so -delete
! "$work/moved/bin/phynness" mesh "$scene" -o "$work/none.msh" 2>"$work/error"
grep -q "gmsh cannot be loaded.*phynness_gmsh.so" "$work/error"
grep -q "remedy: check the installation of libgmsh" "$work/error"
surface=$(dirname "$0")/../data/meshes/sofa_env/gallbladder_surface.stl
sed "s|^shape = .*|file = \"$surface\"\nscale_to_m = 0.001|" "$scene" >"$work/surface.toml"
! "$work/moved/bin/phynness" mesh "$work/surface.toml" -o "$work/none.msh" 2>"$work/error"
grep -q "remedy: check the installation of libgmsh" "$work/error"
