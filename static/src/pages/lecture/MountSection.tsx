import { Mount } from "../../lessons/mount/Mount";
import { mountError } from "../../lessons/stage/controls";
import { Slider } from "../../ui/Slider";
import { Section, type SectionHead } from "./Section";

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

export function MountSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <>
          <Mount />
          <div class="for-stage no-print">
            <Slider
              label="On the stage: rotation of the mount"
              sentence="By how much the mount that the map on the stage is made with is rotated."
              value={mountError.value}
              initial={8}
              low={-20}
              high={20}
              step={1}
              unit="°"
              tone="beam"
              onInput={(value) => {
                mountError.value = value;
              }}
            />
          </div>
        </>
      }
      sources={["rep-103", "rep-105"]}
      after={
        <p>
          Each mount error has a typical effect. A <b>rotated</b> sensor rotates each scan about the sensor, so a wall
          appears in a different place from every pose that saw it. The offset of a <b>shifted</b> sensor rotates with
          the heading of the robot: where the robot turned, walls appear twice; if it had only driven straight, the
          whole map would be displaced and the error could not be seen. A sensor that is <b>upside down</b>, when the
          map does not account for it, mirrors each scan: left and right are exchanged, and a symmetric corridor may
          even look correct.
        </p>
      }
    >
      <p>
        A reading is measured in the frame of the sensor and must be transformed to the frame of the map. This takes two
        poses: the pose of the robot in the map, which comes from SLAM, from localization (AMCL) or from the odometry,
        and the pose of the sensor on the robot, its <b class="noun-beam">mount</b>, which in ROS comes from the robot’s
        description (URDF) by way of the transforms (TF). The third part is the grid’s own origin and resolution. If any
        of the three is wrong, the map is smeared, rotated or mirrored, and walls appear across doors.
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
        The units are metres and radians (the figure shows degrees); x points forward, y to the left, and angles are
        counter-clockwise. The dashed fan is the true mount of the laser, from which the readings were made. The{" "}
        <b class="noun-beam">coloured</b> fan is the mount that the map is made with. Drag it, rotate it, or turn it
        upside down: the path of the robot and the readings stay the same.
      </p>
    </Section>
  );
}
