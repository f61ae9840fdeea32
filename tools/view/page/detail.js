// Meshes in several degrees of detail: as they are, coarse, and as the boxes around them. Much is drawn coarsely, and
// browsers without a graphics card draw little more than boxes.
import * as THREE from "three";

export const kFine = 0;
export const kCoarse = 1;
export const kBoxes = 2;

const kCells = 4;          // along each axis of a coarse mesh
const kFewTriangles = 80;  // these stay as they are

function made(positions, normals, indices) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  return geometry;
}

// Vertices that share a cell of a grid become one: the mean of them.
function coarse({ positions, normals, indices }, box) {
  const size = box.getSize(new THREE.Vector3());
  const cells = new Map();
  const cellOf = [];
  for (let i = 0; i < positions.length; i += 3) {
    const place = [0, 1, 2].map((axis) => {
      const share = (positions[i + axis] - box.min.getComponent(axis)) / (size.getComponent(axis) || 1);
      return Math.min(kCells - 1, Math.floor(kCells * share));
    }).join();
    if (!cells.has(place)) cells.set(place, { number: cells.size, count: 0, sums: [0, 0, 0, 0, 0, 0] });
    const cell = cells.get(place);
    cell.count += 1;
    for (let k = 0; k < 3; ++k) {
      cell.sums[k] += positions[i + k];
      cell.sums[3 + k] += normals[i + k];
    }
    cellOf.push(cell.number);
  }
  const list = [...cells.values()];
  const kept = [];
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [cellOf[indices[i]], cellOf[indices[i + 1]], cellOf[indices[i + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return made(Float32Array.from(list.flatMap(({ sums, count }) => sums.slice(0, 3).map((sum) => sum / count))),
    Float32Array.from(list.flatMap(({ sums }) => {
      const length = Math.hypot(sums[3], sums[4], sums[5]) || 1;
      return sums.slice(3).map((sum) => sum / length);
    })), Uint32Array.from(kept));
}

function boxOf(box) {
  const size = box.getSize(new THREE.Vector3());
  const geometry = new THREE.BoxGeometry(size.x, size.y, size.z);
  geometry.translate(...box.getCenter(new THREE.Vector3()));
  return geometry;
}

// Surfaces stay as they are: they are few, and carry the rest.
export function geometryOf(mesh, detail) {
  mesh.geometries ??= [made(mesh.positions, mesh.normals, mesh.indices)];
  const triangles = mesh.indices.length / 3;
  if (detail === kFine || mesh.isSurface || triangles <= (detail === kBoxes ? 12 : kFewTriangles)) return mesh.geometries[kFine];
  if (!mesh.geometries[detail]) {
    mesh.geometries[kFine].computeBoundingBox();
    const box = mesh.geometries[kFine].boundingBox;
    mesh.geometries[detail] = detail === kBoxes ? boxOf(box) : coarse(mesh, box);
  }
  return mesh.geometries[detail];
}
