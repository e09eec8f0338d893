import { Mount } from "../../lessons/mount/Mount";
import { Section } from "./Section";

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

export function MountSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Mount />}
      sources={["rep-103", "rep-105"]}
      after={
        <p>
          Every way of being wrong has its own handwriting. A <b>turned</b> sensor swings each scan round itself, so
          that one wall lands in another place from every pose that saw it. A <b>shifted</b> one carries its error along
          with the robot’s heading: where the robot turned, walls double; had it only driven straight, the whole map
          would be displaced, and nobody would see it. One that hangs <b>upside down</b>, with nobody telling the map,
          mirrors each scan: left and right change places, and a symmetric corridor may even look right.
        </p>
      }
    >
      <p>
        A reading is made in the sensor’s own frame, and the map wants it in its own. Two poses lie between: where the
        robot is in the map, and where the sensor sits on the robot, its <b class="noun-beam">mount</b>.
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
        All of it in metres and radians (the figure tells them in degrees), x forward, y to the left, angles
        counter-clockwise. The dashed fan is how the laser is really mounted; it made the readings. The{" "}
        <b class="noun-beam">coloured</b> one is what the map believes. Drag it, turn it, hang it upside down: the
        robot’s way and the readings stay the same.
      </p>
    </Section>
  );
}
