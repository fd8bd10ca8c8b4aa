// The fishes of a scene: which parts belong to which, where they are, and which one is under a pointer.
import * as THREE from "three";

const ROUND = 0.75; // radius about the middle of a fish that holds all of it, in lengths
const TOUCH = 0.04; // share of the picture's height that a finger may miss by

export class Fishes {
  constructor(root, about) {
    this.all = about.fishes.map(one => {
      const node = root.getObjectByName(one.node);
      return {
        about: one, node, meshes: [], within: true, radius: ROUND * one.length_cm / 100,
        title: `${about.species[one.species].title} ${one.number}`,
      };
    });
    const owners = new Map(this.all.map(fish => [fish.node, fish]));
    this.others = [];
    root.traverse(mesh => {
      if (!mesh.isMesh) return;
      const start = mesh.isSkinnedMesh ? mesh.skeleton.bones[0] : mesh;
      let fish;
      for (let one = start; one && !fish; one = one.parent) fish = owners.get(one);
      for (let one = mesh; one && !fish; one = one.parent) fish = owners.get(one);
      if (!fish && mesh.isSkinnedMesh) mesh.frustumCulled = false; // seaweed, which no ray looks for
      else if (!fish) this.others.push(mesh);
      else {
        fish.meshes.push(mesh);
        fish.bone = mesh.isSkinnedMesh ? start : mesh;
        mesh.frustumCulled = false; // `cull` knows better where it is
        mesh.boundingSphere = new THREE.Sphere(); // moves with the fish, below
      }
    });
    this.sphere = new THREE.Sphere();
    this.frustum = new THREE.Frustum();
    this.ray = new THREE.Raycaster();
  }

  // Hide the fishes that are not in the sea in a frame.
  show(frame) {
    for (const fish of this.all)
      fish.within = fish.about.first <= frame && frame <= fish.about.last;
  }

  // Where the middle of a fish is now.
  place(fish) {
    return fish.bone.getWorldPosition(new THREE.Vector3());
  }

  // Skip what a camera does not see.
  cull(camera) {
    const both = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.frustum.setFromProjectionMatrix(both);
    for (const fish of this.all) {
      this.sphere.set(this.place(fish), fish.radius);
      const seen = fish.within && this.frustum.intersectsSphere(this.sphere);
      for (const mesh of fish.meshes) mesh.visible = seen;
    }
  }

  // The nearest fish at x, y (-1 to 1) of the picture, null for none; a finger may miss a little.
  at(x, y, camera, finger) {
    this.ray.setFromCamera(new THREE.Vector2(x, y), camera);
    const ray = this.ray.ray;
    let best = null, least = Infinity;
    const near = [];
    for (const fish of this.all) {
      if (!fish.within) continue;
      this.sphere.set(this.place(fish), fish.radius);
      if (!ray.intersectsSphere(this.sphere)) continue;
      near.push(fish);
      for (const mesh of fish.meshes) {
        // The ray's test would else use the sphere of an earlier moment.
        if (mesh.isSkinnedMesh) mesh.boundingSphere.copy(this.sphere).applyMatrix4(mesh.matrixWorld.clone().invert());
        for (const hit of this.ray.intersectObject(mesh, false))
          if (hit.distance < least) [best, least] = [fish, hit.distance];
      }
    }
    if (!best && finger) {
      let missed = TOUCH;
      for (const fish of near) {
        const place = this.place(fish).project(camera);
        const way = Math.hypot((place.x - x) * camera.aspect, place.y - y);
        if (way < missed) [best, missed] = [fish, way];
      }
      if (best) least = this.place(best).distanceTo(camera.position);
    }
    if (best && this.others.length) {
      this.ray.far = least;
      const hidden = this.ray.intersectObjects(this.others, false).length > 0;
      this.ray.far = Infinity;
      if (hidden) return null;
    }
    return best;
  }
}
