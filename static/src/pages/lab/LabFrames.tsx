/** The frames of the lab's robot (REP 105) and the transforms between them, now. */

import { between } from "../../grid/poses";
import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import type { Pose } from "../../wire/protocol";

const metres = (value: number): string => written(value, 2);
const degrees = (value: number): string => written((value * 180) / Math.PI, 1);

export function LabFrames({ store }: { readonly store: Store }) {
  const frame = store.frame.value;
  if (!frame) return null;
  const { pose, believed_pose, sensor_pose } = frame;
  const rows: readonly (readonly [child: string, parent: string, whose: string, pose: Pose])[] = [
    ["base_link", "map", "as the robot believes", believed_pose ?? pose],
    ["base_link", "map", "true", pose],
    ["laser", "base_link", "its mount", between(pose, sensor_pose)],
  ];
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, which the keyboard can only do with the focus in it
    <div class="lab-frames" tabIndex={0}>
      <table>
        <caption class="quiet">
          Each transform now. The wheels’ drift, if it is on, is in the pose that is believed.
        </caption>
        <thead>
          <tr>
            <th scope="col">frame</th>
            <th scope="col">x, m</th>
            <th scope="col">y, m</th>
            <th scope="col">yaw, °</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([child, parent, whose, [x, y, yaw]]) => (
            <tr key={whose}>
              <th scope="row">
                {child}{" "}
                <span class="quiet">
                  in {parent}, {whose}
                </span>
              </th>
              <td class="number">{metres(x)}</td>
              <td class="number">{metres(y)}</td>
              <td class="number">{degrees(yaw)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
