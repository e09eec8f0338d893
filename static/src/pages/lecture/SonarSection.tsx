import { signal } from "@preact/signals";
import type { SonarSettings } from "../../lessons/sonar/model";
import { Sonar } from "../../lessons/sonar/Sonar";
import { Scrub } from "../../ui/Scrub";
import { Section } from "./Section";

const DEGREE = Math.PI / 180;
const settings = signal<SonarSettings>({ opening: 30 * DEGREE, window: 0.2, profile: "flat", no_return: "ignore" });

export function SonarSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { opening, window: r } = settings.value;
  const set = (change: Partial<SonarSettings>): void => {
    settings.value = { ...settings.peek(), ...change };
  };
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Sonar settings={settings} />}
      sources={[
        ["moravec-elfes", ""],
        ["elfes", ""],
        ["probabilistic-robotics", "sections 9.2 and 9.4"],
      ]}
      after={
        <>
          <p>
            Go back to one reading and let the others come in again. To <b>Bayes’ filter</b>, cell by cell, every cell
            of an arc is hit, and with the flat profile all of them equally: the evidence of one echo is added as often
            as the arc has cells. What saves the map is that other cones pass through most of them. What it costs is
            under the cross: arcs from both sides of the open door lie across it, and the map has walled it up.
          </p>
          <p>
            <b>Moravec and Elfes</b> kept two numbers a cell, and knew section 1’s trouble. An arc’s certainty that
            something is there is first cancelled where the cell is known to be <b class="noun-miss">empty</b>, then
            scaled so that the whole arc holds just one obstacle, and only then added:
          </p>
          <math display="block" class="lesson-formula">
            <mrow>
              <mi>O</mi>
              <mo>←</mo>
              <mfrac>
                <mrow>
                  <mi>O</mi>
                  <mo>(</mo>
                  <mn>1</mn>
                  <mo>−</mo>
                  <mi class="noun-miss">Emp</mi>
                  <mo>)</mo>
                </mrow>
                <mrow>
                  <mo>∑</mo>
                  <mi>O</mi>
                  <mo>(</mo>
                  <mn>1</mn>
                  <mo>−</mo>
                  <mi class="noun-miss">Emp</mi>
                  <mo>)</mo>
                </mrow>
              </mfrac>
            </mrow>
          </math>
          <math display="block" class="lesson-formula">
            <mrow>
              <mi class="noun-hit">Occ</mi>
              <mo>←</mo>
              <mi class="noun-hit">Occ</mi>
              <mo>+</mo>
              <mi>O</mi>
              <mo>−</mo>
              <mi class="noun-hit">Occ</mi>
              <mo>⋅</mo>
              <mi>O</mi>
            </mrow>
          </math>
          <p>
            So the blame goes to the cells that are left. It is a heuristic: both numbers can only grow, nothing is ever
            taken back, and the order matters. The map shows the greater of the two. By 1989 Elfes had put the grid on
            Bayes’ rule, and with independent cells came back what section 1 showed.
          </p>
        </>
      }
    >
      <p>
        A laser beam is thin; a sonar’s is a cone, here{" "}
        <Scrub
          label="opening of the cone"
          sentence="The angle, from edge to edge, in which a sonar hears an echo."
          value={Math.round(opening / DEGREE)}
          text={`${Math.round(opening / DEGREE)}° wide`}
          tone="beam"
          low={6}
          high={60}
          step={1}
          after="."
          onInput={(value) => set({ opening: value * DEGREE })}
        />{" "}
        An echo after <b class="noun-beam">z</b> says two things: the cone is probably <b class="noun-miss">free</b> up
        to z, and somewhere on the arc at z, within a window of{" "}
        <Scrub
          label="hit window of the cone"
          sentence="How thick the arc is that counts as hit."
          value={r}
          unit="m"
          tone="hit"
          low={0.1}
          high={0.6}
          step={0.05}
          after=","
          onInput={(value) => set({ window: value })}
        />{" "}
        something is <b class="noun-hit">there</b>. Where on the arc, it does not say. A robot with a ring of 16 sonars,
        each of which reports the nearest surface anywhere in its cone, drives through a room. The same readings make
        both maps.
      </p>
    </Section>
  );
}
