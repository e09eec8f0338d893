import type { Store } from "../../store/store";
import { Working } from "../../ui/Working";
import { computingText } from "../parts";

/** The progress of a long computation of the session, over the picture of its map, with a button that cancels it. */
export function ComputingMap({ store }: { readonly store: Store }) {
  return (
    <Working
      what={computingText(store.working.value?.what ?? "") ?? "Computing the map"}
      work={store.working.value}
      onCancel={() => store.send({ type: "cancel" })}
      isInside
    />
  );
}
