// Angles, points of disks and directions. Directions point away from the surface; θ is from the normal of the side they lie on.

import type { Direction } from "./core";

const RADIAN = Math.PI / 180;

/** The direction at θ, φ in degrees, on the front or the back. */
export function fromPolar(thetaDeg: number, phiDeg: number, front: boolean): Direction {
  const sine = Math.sin(thetaDeg * RADIAN);
  const z = Math.cos(thetaDeg * RADIAN);
  return [sine * Math.cos(phiDeg * RADIAN), sine * Math.sin(phiDeg * RADIAN), front ? z : -z];
}

/** θ and φ in degrees, φ from 0 to 360. */
export function toPolar([x, y, z]: Direction): { thetaDeg: number; phiDeg: number } {
  const thetaDeg = Math.atan2(Math.hypot(x, y), Math.abs(z)) / RADIAN;
  return { thetaDeg, phiDeg: (Math.atan2(y, x) / RADIAN + 360) % 360 };
}

/** The direction over a point of the disk; null outside of it. */
export function fromDisk(x: number, y: number, front: boolean): Direction | null {
  const rest = 1 - x * x - y * y;
  if (rest <= 0) return null;
  return [x, y, front ? Math.sqrt(rest) : -Math.sqrt(rest)];
}

/** The exitant direction at an angle from the normal in the plane of an incident one; positive towards where mirrored and straight light goes. At normal
 * incidence the plane is that of X. */
export function inPlane([x, y]: Direction, angleDeg: number, front: boolean): Direction {
  const phiDeg = x === 0 && y === 0 ? 0 : Math.atan2(-y, -x) / RADIAN;
  return fromPolar(angleDeg, phiDeg, front);
}

/** What one press of an arrow key moves an incident direction, in degrees. */
const STEP_DEG = 1;
/** Nothing comes in along the surface itself. */
export const MOST_THETA_DEG = 89.9;

/** The direction after an arrow key: up and down are θ, left and right φ. Null for other keys. */
export function stepped(direction: Direction, key: string): Direction | null {
  const move = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] }[key];
  if (!move) return null;
  const { thetaDeg, phiDeg } = toPolar(direction);
  const theta = Math.min(MOST_THETA_DEG, Math.max(0, thetaDeg + STEP_DEG * move[0]!));
  return fromPolar(theta, phiDeg + STEP_DEG * move[1]!, direction[2] > 0);
}
