import { type LaterId, later } from "../../lessons/stage/later";

/** The figure of a section whose code is fetched after the first ones; empty on a slide until then. */
export function LaterFigure({ id }: { readonly id: LaterId }) {
  const Figure = later.value?.[id].figure;
  return Figure ? <Figure /> : <figure aria-busy="true" />;
}

/** The figure in the text after the figure of such a section. */
export function LaterMore({ id }: { readonly id: LaterId }) {
  const More = later.value?.[id].more;
  return <div class="lesson-more">{More && <More />}</div>;
}
