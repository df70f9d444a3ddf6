export default {
  extends: "stylelint-config-standard",
  rules: {
    "declaration-block-single-line-max-declarations": 6,
    "declaration-empty-line-before": null,
    "rule-empty-line-before": null,
  },
};
