//! What is shown: a scene, its nets, and where one starts.

use crate::ask::Ask;
use glam::Vec3;
use rrf_field::Field;
use rrf_render::{Lights, Renderer, Trusted, View, notices, on_surface};
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use serde_json::{Value, json};

/// A baked scene to look at.
pub struct Show<'a> {
    /// The scene as baked, without its own lights.
    pub tracer: &'a Tracer<'a>,
    /// The nets.
    pub field: &'a Field,
    /// Which rows the nets were trained for.
    pub trusted: &'a Trusted<'a>,
    /// Whether a free place is inside a solid.
    pub inside_solid: &'a (dyn Fn(Vec3) -> bool + Sync),
    /// Least and greatest corner of the baked light box.
    pub light_box: [Vec3; 2],
    /// The same of the box that eyes were expected in.
    pub eye_box: Option<[Vec3; 2]>,
    /// Where the page starts to look from.
    pub view: View,
    /// What shines at first.
    pub lights: Vec<PointLight>,
    /// The run folder, as the equivalent command names it.
    pub run: String,
}

impl<'a> Show<'a> {
    /// A renderer for one viewer.
    pub fn renderer(&self) -> Renderer<'a> {
        Renderer::new(self.tracer, self.field)
    }

    /// What a page has to know before its first question.
    pub fn hello(&self) -> Value {
        let view = &self.view;
        let bounds = self.tracer.scene().bounds();
        let [low, high] = bounds.map_or([[0.0; 3], [1.0; 3]], |b| [b.min, b.max]);
        let light = |l: &PointLight| [l.position.to_array(), l.intensity.to_array()].concat();
        json!({
            "run": self.run,
            "eye": view.eye.to_array(),
            "right": view.right.to_array(),
            "up": view.up.to_array(),
            "forward": view.forward.to_array(),
            "fov": view.fov,
            "size": [view.width, view.height],
            "lights": self.lights.iter().map(light).collect::<Vec<_>>(),
            "light_box": self.light_box.map(|corner| corner.to_array()),
            "bounds": [low, high],
            "cells": self.field.models().len(),
            "triangles": self.tracer.scene().triangles.len(),
        })
    }

    /// What a viewer should know of a view and its lights, as sentences.
    pub fn notices(&self, ask: &Ask) -> Vec<String> {
        let positions = ask.lights().points.into_iter().map(|light| light.position);
        let told = notices(
            ask.view().eye,
            positions,
            Some(self.light_box),
            self.eye_box,
            self.inside_solid,
            |place| on_surface(self.tracer, place),
            |place, reach| self.tracer.distance(place, reach),
        );
        told.iter().map(ToString::to_string).collect()
    }

    /// Point lights alone: the page's frames are those of the nets.
    pub fn lights(points: Vec<PointLight>) -> Lights {
        Lights {
            points,
            area: false,
        }
    }
}
