import { Mount } from "../../../lessons/mount/Mount";
import { mountError } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { Slider } from "../../../ui/Slider";
import { Section, type SectionHead } from "../Section";

/** T with its two frames as indices. */
function Transform({ a, b, tone }: { a: string; b: string; tone: string }) {
  return (
    <msub class={tone}>
      <mi>T</mi>
      <mtext>
        {a} {b}
      </mtext>
    </msub>
  );
}

export function MountSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <>
          <Mount />
          <div class="for-stage no-print">
            <Slider
              label="On the stage: rotation of the mount"
              sentence="Rotation of the mount that the stage’s map assumes."
              {...bound(mountError)}
              initial={8}
              low={-20}
              high={20}
              step={1}
              unit="°"
              tone="beam"
            />
          </div>
        </>
      }
      sources={["rep-103", "rep-105"]}
      after={
        <>
          <p>
            A <b>rotated</b> sensor rotates each scan about itself, so a wall appears in a different place from every
            pose. The offset of a <b>shifted</b> sensor rotates with the heading: walls appear twice where the robot
            turned, and a straight drive hides the error. A sensor <b>upside down</b> mirrors each scan.
          </p>
          <p>
            The pose must be that of the moment of the reading: where clocks differ, walls fan out in every turn. A scan
            takes time: in a turn each beam needs its own pose, or walls tear where the scan begins and ends.
          </p>
        </>
      }
    >
      <p>
        A reading is measured in the frame of the sensor. Two poses, composed (∘), place it in the map: the pose of the
        robot in the map, and that of the sensor on the robot, its <b class="noun-beam">mount</b> (in ROS stated in the
        URDF, the robot’s description). The first comes from odometry, which adds up the turns of the wheels, from
        localization, or from SLAM (simultaneous localization and mapping). If a pose or the grid’s origin or resolution
        is wrong, the map is smeared, rotated or mirrored.
      </p>
      <math display="block" class="lesson-formula">
        <mrow>
          <Transform a="map" b="laser" tone="" />
          <mo>=</mo>
          <Transform a="map" b="base" tone="noun-robot" />
          <mo>∘</mo>
          <Transform a="base" b="laser" tone="noun-beam" />
        </mrow>
      </math>
      <p>
        <i>x</i> points forward, <i>y</i> left; angles are counter-clockwise. The dashed fan is the true mount, the{" "}
        <b class="noun-beam">coloured</b> one the mount that the map assumes.{" "}
        <span class="no-print">Drag it, rotate it, or turn it upside down.</span>
      </p>
    </Section>
  );
}
