import { Matching } from "../../../lessons/matching/Matching";
import { Sketch, type SketchName } from "../../../lessons/matching/Sketch";
import { Section, type SectionHead } from "../Section";

/** The methods of scan matching, each with its drawing and one sentence. */
const REALIZATIONS: readonly {
  readonly name: string;
  readonly sketch: SketchName;
  readonly sentence: string;
}[] = [
  {
    name: "ICP",
    sketch: "icp",
    sentence: "Pairs of nearest points, again and again, as in the figure.",
  },
  {
    name: "Scan to scan",
    sketch: "scan-to-scan",
    sentence: "Each scan is matched with the one before; small errors still add up.",
  },
  {
    name: "Scan to map",
    sketch: "scan-to-map",
    sentence: "Each scan is matched with the map so far, or its newest part; errors add up more slowly.",
  },
  {
    name: "Map to map",
    sketch: "map-to-map",
    sentence: "Two maps of a few scans each are matched; they show more than single scans.",
  },
  {
    name: "Feature-based",
    sketch: "features",
    sentence: "Corners and straight walls are found in both, and matched instead of points.",
  },
  {
    name: "RANSAC",
    sketch: "ransac",
    sentence: "Poses are computed from a few pairs drawn at random; the one that most pairs agree with is kept.",
  },
  {
    name: "Correlative",
    sketch: "correlative",
    sentence: "Every pose of a window is scored on a raster; upper bounds from a coarser raster rule most out.",
  },
];

export function MatchingSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Matching />}
      sources={["besl-mckay", "censi", "olson", "hess", "ransac"]}
      after={
        <>
          <p>
            The <b class="noun-beam">colour</b> is the score of every position at the current heading. ICP needs a start
            in the <b class="noun-miss">blue</b> part of the second picture. The <b>correlative</b> method tries every
            pose of its window.
          </p>
          <p>
            In the corridor any pose along the walls fits; in the symmetric room two fit equally. A moved table shifts
            the pose a little; leaving out the worst tenth of the pairs limits this.
          </p>
          <h3>The methods</h3>
          <ul class="realizations">
            {REALIZATIONS.map(({ name, sketch, sentence }) => (
              <li key={name}>
                <Sketch name={sketch} />
                <p>
                  <b>{name}.</b> {sentence}
                </p>
              </li>
            ))}
          </ul>
          <p>
            Dark: known; <b class="noun-robot">green</b>: matched to it.
          </p>
        </>
      }
    >
      <p>
        To correct a pose, the scan is aligned with another scan or with the map. <b>ICP</b> (iterative closest point)
        pairs each point with the nearest one, moves the scan so that the pairs fit, and repeats. Segments in the figure
        join the pairs: <b>point to point</b> makes them short, <b>point to line</b> only their part across the wall, so
        a scan slides along it.{" "}
        <span class="no-print">
          Drag the <b class="noun-robot">scan</b> until it snaps; the outer handle turns it.
        </span>
      </p>
    </Section>
  );
}
