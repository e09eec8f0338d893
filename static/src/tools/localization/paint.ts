/** The drawing of a localized robot over the belief: the best estimate, its uncertainty, and the scan from there. */

import { compose } from "../../grid/lattice";
import { type Brush, paintBeams, robotPx } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import type { Pose } from "../../wire/protocol";
import { ellipseOf } from "./model";

const CROSS_PX = 10;

/** Pose `b` relative to pose `a`: the inverse of `a`, composed with `b`. */
function seenFrom(a: Pose, b: Pose): Pose {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const [c, s] = [Math.cos(a[2]), Math.sin(a[2])];
  return [c * dx + s * dy, c * dy - s * dx, b[2] - a[2]];
}

/** Paint the visitor's estimate of the robot's pose: a ring, and a line in its heading. */
export function paintGivenPose(store: Store, { ctx, view, size, colours }: Brush): void {
  const pose = store.givenPose.peek();
  if (!pose) return;
  const [x, y] = toScreen(view, size, pose[0], pose[1]);
  const radius = robotPx(view) + 3;
  for (const [style, width] of [
    [colours.outline, 5],
    [colours.robot, 2.5],
  ] as const) {
    ctx.strokeStyle = style;
    ctx.lineWidth = width;
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.moveTo(x, y);
    ctx.lineTo(x + 2.4 * radius * Math.cos(pose[2]), y - 2.4 * radius * Math.sin(pose[2]));
    ctx.stroke();
  }
}

/** Paint the estimate; nothing if the robot is not localized. */
export function paintLocalization(store: Store, brush: Brush): void {
  const message = store.part("localization").message.peek();
  const frame = store.frame.peek();
  if (!message?.pose || !message.at || !message.covariance) return;
  const { ctx, view, size, colours } = brush;
  const { at, covariance } = message;
  // The robot has moved since, so the estimate is updated with its true motion, which is short.
  const pose = frame ? compose(message.pose, seenFrom(at, frame.pose)) : message.pose;
  const [xx, xy, yy] = covariance;
  const [x, y] = toScreen(view, size, pose[0], pose[1]);
  if (frame && message.is_converged) {
    // The scan was taken at the newest scan's pose. Drawn from the estimate, it matches the walls if that is right.
    const mount = seenFrom(frame.pose, frame.scan_pose);
    paintBeams(brush, compose(pose, mount), frame, frame.range_max, 0.35, 1.5);
  }
  const [long, short, turn] = ellipseOf(xx, xy, yy);
  ctx.lineWidth = 2;
  ctx.strokeStyle = colours.outline;
  ctx.setLineDash(message.is_converged ? [] : [6, 5]);
  ctx.beginPath();
  ctx.ellipse(x, y, Math.max(long / view.scale, 3), Math.max(short / view.scale, 3), -turn, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.moveTo(x - CROSS_PX, y);
  ctx.lineTo(x + CROSS_PX, y);
  ctx.moveTo(x, y - CROSS_PX);
  ctx.lineTo(x, y + CROSS_PX);
  ctx.stroke();
}
